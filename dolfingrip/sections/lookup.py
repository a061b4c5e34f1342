"""Finds the classes of an index: one in each of its files, and those of plugins."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from types import ModuleType

from dolfingrip import plugins
from dolfingrip.plugins import PluginError


def classes[T](group: str, package: str, files: Sequence[str], base: type[T]) -> dict[str, type[T]]:
    """Return the classes of an index by their files' names, those of plugins last.

    Args:
        group: one of :data:`dolfingrip.plugins.GROUPS`.
        package: dotted name of the folder with the files.
        files: names of the files.
        base: base class of the kind.

    Raises:
        PluginError: one line, where a plugin cannot be loaded, has two such classes, or has a name
            that is taken.
    """
    by_name = {file: only_class(f"{package}.{file}", base) for file in files}
    for plugin in plugins.of_group(group):
        name, kinds = plugin.module.rpartition(".")[2], _classes(plugin.load(), base)
        if kinds and name in by_name:
            raise PluginError(f"--plugin {plugin.path}: {name} is taken; allowed: another name")
        if len(kinds) > 1:
            words = " and ".join(kind.__name__ for kind in kinds)
            raise PluginError(f"--plugin {plugin.path}: {words}; allowed: one of {group} in a file")
        if kinds:
            by_name[name] = kinds[0]
    return by_name


def only_class[T](module: str, base: type[T]) -> type[T]:
    """Return the one class of a kind that is defined in a file.

    Args:
        module: dotted name of the file.
        base: base class of the kind.
    """
    (kind,) = _classes(importlib.import_module(module), base)
    return kind


def _classes[T](module: ModuleType, base: type[T]) -> list[type[T]]:
    """Return the classes of a kind that are defined in a module."""
    return [
        item
        for item in vars(module).values()
        if isinstance(item, type) and issubclass(item, base) and item.__module__ == module.__name__
    ]
