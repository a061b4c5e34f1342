"""Laws, effects, foods and other things of a user's own, from files and from installed packages.

``--plugin my_law.py`` or :func:`add` names a file. It is the module ``dolfingrip.plugins.my_law``,
which is executed once, when the index is read that it adds to. An installed package names modules
by entry points of the groups ``dolfingrip.laws``, ``dolfingrip.effects`` and so on. A configuration
can name a thing of a plugin, and loads none.

The paths of the files stand in an environment variable, which all processes inherit that are
started here.
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import os
import sys
import traceback
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, Final

VARIABLE: Final = "DOLFINGRIP_PLUGINS"
"""Environment variable with the paths of the files."""

GROUPS: Final = {
    "readings": "dolfingrip.channels.Channel",
    "laws": "dolfingrip.sections.laws",
    "geometries": "dolfingrip.sections.geometry",
    "effects": "dolfingrip.extensions",
    "foods": "dolfingrip.foods",
    "experiments": "dolfingrip.experiments",
    "quantities": "dolfingrip.design.quantities",
    "pages": "dolfingrip.report.page",
}
"""What a plugin can add, and what its file then imports at its top."""

__path__: list[str] = []
"""Makes this module a package, whose modules :class:`_Files` finds."""


class PluginError(ValueError):
    """One line about a plugin that cannot be taken."""


@dataclass(frozen=True, slots=True)
class Plugin:
    """A module of a user's own.

    Attributes:
        module: its dotted name.
        path: of its file.
        version: of the installed package; "" of a file.
    """

    module: str
    path: str
    version: str = ""

    @property
    def digest(self) -> str:
        """SHA-256 of the file as it was when it was first read here."""
        return _digest(self.path)

    def load(self) -> ModuleType:
        """Execute the module, once.

        Raises:
            PluginError: one line, where that fails.
        """
        try:
            loaded = importlib.import_module(self.module)
        except PluginError:
            raise
        except Exception as error:  # whatever the user's code does
            lines = [f.lineno for f in traceback.extract_tb(error.__traceback__)
                     if f.filename == self.path]  # fmt: skip
            where = f"line {lines[-1]}: " if lines else ""
            raise PluginError(
                f"--plugin {self.path}: {where}{type(error).__name__}: {error}"
            ) from error
        _LOADED[self.module] = self
        return loaded


_LOADED: dict[str, Plugin] = {}
_ASKED: set[str] = set()


class _Files(MetaPathFinder):
    """Finds the module of a plugin's file."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        parent, _, stem = fullname.rpartition(".")
        file = files().get(stem) if parent == __name__ else None
        return None if file is None else spec_from_file_location(fullname, file)


sys.meta_path.append(_Files())


def files() -> Mapping[str, Path]:
    """Return the files that were named, by the names of their modules."""
    named = os.environ.get(VARIABLE, "").split(os.pathsep)
    return {Path(file).stem: Path(file) for file in named if file}


def add(path: os.PathLike[str] | str) -> None:
    """Take a file of laws, effects, foods, or other things of one's own.

    It has to come before the configuration is imported, which is made of all things that there are.

    Args:
        path: of the file; one that was taken before stays.

    Raises:
        PluginError: one line, where the file cannot be read or adds nothing, or comes too late.
    """
    file, named = Path(path).resolve(), files()
    if named.get(file.stem) == file:
        return
    groups = _groups(file)
    if not file.stem.isidentifier() or file.stem in named:
        why = "two files of this name" if file.stem in named else "no name of Python"
        raise PluginError(f"--plugin {path}: {why}; allowed: another name, as my_law.py")
    if late := groups & _ASKED:
        raise PluginError(
            f"--plugin {path}: {', '.join(sorted(late))} are loaded; allowed: dolfingrip.plugin() "
            "before dolfingrip.config or an experiment is imported; start Python anew"
        )
    os.environ[VARIABLE] = os.pathsep.join(map(str, [*named.values(), file]))


def taken(arguments: Sequence[str]) -> list[str]:
    """Take the files that a command line names, before its commands are made.

    Args:
        arguments: ``--plugin FILE`` may stand anywhere among them.

    Returns:
        The arguments, those of plugins first.

    Raises:
        PluginError: one line, where one of these files cannot be taken.
    """
    plugins: list[str] = []
    others: list[str] = []
    left = iter(arguments)
    for argument in left:
        if argument != "--plugin" and not argument.startswith("--plugin="):
            others.append(argument)
            continue
        path = next(left, "") if argument == "--plugin" else argument.removeprefix("--plugin=")
        if not path:
            raise PluginError("--plugin: allowed: --plugin FILE.py")
        add(path)
        plugins += ["--plugin", path]
    return [*plugins, *others]


def of_group(group: str) -> Iterator[Plugin]:
    """Yield the plugins that may add to an index; later ones are refused from then on.

    Args:
        group: one of :data:`GROUPS`.

    Raises:
        PluginError: one line, where a file cannot be read.
    """
    _ASKED.add(group)
    for stem, file in files().items():
        if group in _groups(file):
            yield Plugin(f"{__name__}.{stem}", str(file))
    for entry in _installed().select(group=f"dolfingrip.{group}"):
        spec = find_spec(entry.module)
        if spec is None or spec.origin is None or entry.dist is None:
            raise PluginError(f"dolfingrip.{group}: {entry.value}: no such module")
        yield Plugin(entry.module, spec.origin, f"{entry.dist.name} {entry.dist.version}")


def digests(*things: Any) -> dict[str, str]:
    """Return the digests, by module, of the plugins that classes, their bases or functions are of.

    Args:
        things: classes and functions.
    """
    modules = [
        getattr(base, "__module__", "")
        for definition in things
        for base in getattr(definition, "__mro__", [definition])
    ]
    used = {name: _LOADED[name] for name in modules if name in _LOADED}
    return {name: f"{loaded.digest} {loaded.version}".rstrip() for name, loaded in used.items()}


def digests_of_files() -> dict[str, str]:
    """Return the digests by path of the files that were named."""
    return {str(file): _digest(str(file)) for file in files().values()}


def loaded() -> tuple[Plugin, ...]:
    """Return the plugins of this process."""
    return tuple(_LOADED.values())


def hint(name: str) -> str:
    """Return what a refusal of an unknown name adds: the plugin that may have it.

    Args:
        name: of a law, an effect or another thing, which is mostly that of its file.
    """
    stem = name.replace("-", "_")
    return f"or one of your own, by --plugin {stem if stem.isidentifier() else 'FILE'}.py"


@cache
def _installed() -> metadata.EntryPoints:
    return metadata.entry_points()


@cache
def _digest(path: str) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


@cache
def _groups(file: Path) -> frozenset[str]:
    """Return the groups that a file may add to, by its imports."""
    try:
        tree = ast.parse(file.read_bytes(), str(file))
    except OSError as error:
        raise PluginError(f"--plugin {file}: {error.strerror}") from None
    except (SyntaxError, ValueError) as error:
        line = f"line {error.lineno}: " if isinstance(error, SyntaxError) else ""
        raise PluginError(f"--plugin {file}: {line}{getattr(error, 'msg', error)}") from None
    names: set[str] = set()
    for node in tree.body:
        if isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}.{alias.name}." for alias in node.names}
        elif isinstance(node, ast.Import):
            names |= {f"{alias.name}." for alias in node.names}
    groups = frozenset(
        group
        for group, room in GROUPS.items()
        if any(name.startswith(f"{room}.") for name in names)
    )
    if not groups:
        rooms = ", ".join(GROUPS.values())
        raise PluginError(f"--plugin {file}: allowed: a file that imports from one of {rooms}")
    return groups
