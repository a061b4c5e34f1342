"""Results in folders: what kind each is, told by its files."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from dolfingrip.sections.errors import ConfigError

MARKS: Final = {
    "run": "run.json",
    "optimise": "optimum.json",
    "train": "surrogate.json",
    "diagnose": "diagnosis.json",
    "design": "design.json",
    "study": "combinations.csv",
    "doe": "campaign.sqlite",
}
"""The file by which each kind of result is known; of two, the first counts."""

EXPLORED: Final = "explore"
"""Name of a folder that the explorer keeps its solutions in; they are no results of a page."""

DEEPEST: Final = 3
"""How many folders deep results are looked for: a demo's loop is two deep."""


@dataclass(frozen=True, slots=True)
class Source:
    """A folder with a result.

    Attributes:
        kind: a key of :data:`MARKS`.
    """

    kind: str
    folder: Path


def find(places: Sequence[Path]) -> list[Source]:
    """The results in these folders and below them, in order, each once.

    Raises:
        ConfigError: one line that names a folder without results.
    """
    found: dict[Path, Source] = {}
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


def _below(folder: Path, depth: int) -> Iterator[Source]:
    kind = kind_of(folder)
    if kind is not None:
        yield Source(kind, folder)
        return
    if depth < DEEPEST:
        inside = (path for path in folder.iterdir() if path.is_dir() and path.name != EXPLORED)
        for each in sorted(inside):
            yield from _below(each, depth + 1)


def read_json(file: Path) -> dict[str, Any]:
    """The object in a JSON file.

    Raises:
        ConfigError: one line, if it cannot be read or holds no object.
    """
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{file}: {error.strerror}") from None
    except ValueError as error:
        raise ConfigError(f"{file}: not JSON: {error}") from None
    if not isinstance(content, dict):
        raise ConfigError(f"{file}: no JSON object; allowed: a file that dolfingrip wrote")
    return content
