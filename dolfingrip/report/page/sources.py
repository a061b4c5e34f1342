"""The index of kinds of results: the folders that hold them, and the page that shows them."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from dolfingrip.files.table import Columns
from dolfingrip.report.page import results
from dolfingrip.report.page.content import Contribution, FoundResult, Page
from dolfingrip.report.page.key_numbers import MOST, summary
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.lookup import classes

CONTRIBUTIONS: Final[tuple[Contribution, ...]] = tuple(
    sorted(
        (
            kind()
            for kind in classes(
                "pages",
                results.__name__,
                [file.name for file in pkgutil.iter_modules(results.__path__)],
                Contribution,
            ).values()
        ),
        key=lambda contribution: contribution.place,
    )
)
"""One for each file of ``page/results``, in the order of the page."""

MARKS: Final[Mapping[str, str]] = {
    kind: mark for each in CONTRIBUTIONS for kind, mark in each.marks.items()
}
"""The file by which each kind of result is known; of two in a folder, the first counts."""

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
    by_folder: dict[Path, FoundResult] = {}
    for place in places:
        if not place.exists():
            raise ConfigError(f"RUN {place}: no such folder; allowed: a folder with results")
        inside = list(_below(place.parent if place.is_file() else place, 0))
        if not inside:
            files = ", ".join(MARKS.values())
            raise ConfigError(f"RUN {place}: no results in it; allowed: a folder with {files}")
        for result in inside:
            by_folder.setdefault(result.folder.resolve(), result)
    return list(by_folder.values())


def kind_of(folder: Path) -> str | None:
    """The kind of result in this folder; None if it has none."""
    return next((kind for kind, mark in MARKS.items() if (folder / mark).is_file()), None)


def _below(folder: Path, depth: int) -> Iterator[FoundResult]:
    kind = kind_of(folder)
    if kind is not None:
        yield FoundResult(kind, folder)
        for name in next(c.inside for c in CONTRIBUTIONS if kind in c.marks):
            if (inner := kind_of(folder / name)) is not None:
                yield FoundResult(inner, folder / name, inside=True)
        return
    if depth < DEEPEST:
        inside = (path for path in folder.iterdir() if path.is_dir() and path.name != EXPLORED)
        for child in sorted(inside):
            yield from _below(child, depth + 1)


def build(results: Sequence[FoundResult], measured: Columns | None = None, title: str = "") -> Page:
    """Gather everything on the page of these results.

    Args:
        results: folders with results, at least one.
        measured: columns of a measurement, drawn beside the curves; None: there is none.
        title: of the page; "": made of the results.

    Returns:
        The page.

    Raises:
        ResultFileError: one line, if a result cannot be read.
        ConfigError: one line, if its configuration cannot.
    """
    page, names = Page(title), []
    for contribution in CONTRIBUTIONS:
        of_kind = [result for result in results if result.kind in contribution.marks]
        if of_kind:
            names += contribution.add(page, of_kind, measured)
    page.checks.sort(key=lambda check: ("fail", "open", "", "pass").index(check.verdict))
    checked = summary(page.checks)
    page.numbers = page.numbers[: MOST - len(checked)] + checked
    once = list(dict.fromkeys(names))
    text = once[0] if len(once) == 1 else f"{', '.join(once[:-1])} and {once[-1]}"
    page.title = title or text[0].upper() + text[1:]
    return page
