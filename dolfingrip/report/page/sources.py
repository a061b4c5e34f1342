"""Results in folders: what kind each is, told by its files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from dolfingrip.report.page.contribution import FoundResult
from dolfingrip.report.page.index import MARKS
from dolfingrip.sections.errors import ConfigError

EXPLORED: Final = "explore"
"""Name of a folder that the explorer keeps its solutions in; they are no results of a page."""

DEEPEST: Final = 3
"""How many folders deep results are looked for: a demo's loop is two deep."""


def find(places: Sequence[Path]) -> list[FoundResult]:
    """Find the results in these folders and below them.

    Args:
        places: folders, or files in them.

    Returns:
        The results in order, each once.

    Raises:
        ConfigError: one line that names a folder without results.
    """
    found: dict[Path, FoundResult] = {}
    for place in places:
        if not place.exists():
            raise ConfigError(f"RUN {place}: no such folder; allowed: a folder with results")
        inside = list(_below(place.parent if place.is_file() else place, 0))
        if not inside:
            files = ", ".join(MARKS.values())
            raise ConfigError(f"RUN {place}: no results in it; allowed: a folder with {files}")
        for each in inside:
            found.setdefault(each.folder.resolve(), each)
    return list(found.values())


def kind_of(folder: Path) -> str | None:
    """The kind of result in this folder; None if it has none."""
    return next((kind for kind, mark in MARKS.items() if (folder / mark).is_file()), None)


def _below(folder: Path, depth: int) -> Iterator[FoundResult]:
    kind = kind_of(folder)
    if kind is not None:
        yield FoundResult(kind, folder)
        return
    if depth < DEEPEST:
        inside = (path for path in folder.iterdir() if path.is_dir() and path.name != EXPLORED)
        for each in sorted(inside):
            yield from _below(each, depth + 1)
