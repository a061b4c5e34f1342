"""Finds the class in a file of an index."""

from __future__ import annotations

import importlib


def only_class[T](module: str, base: type[T]) -> type[T]:
    """Return the one class of a kind that is defined in a file.

    Args:
        module: dotted name of the file.
        base: base class of the kind.
    """
    loaded = importlib.import_module(module)
    (found,) = (
        item
        for item in vars(loaded).values()
        if isinstance(item, type) and issubclass(item, base) and item.__module__ == loaded.__name__
    )
    return found
