"""Finds the class in a file of an index."""

from __future__ import annotations

import importlib


def only_class[T](module: str, base: type[T]) -> type[T]:
    """The one class of ``base``'s kind that is defined in the file of this dotted name."""
    loaded = importlib.import_module(module)
    (found,) = (
        item
        for item in vars(loaded).values()
        if isinstance(item, type) and issubclass(item, base) and item.__module__ == loaded.__name__
    )
    return found
