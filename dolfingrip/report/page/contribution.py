"""The base class of what a kind of result contributes to a page."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from dolfingrip.files.columns import Columns
from dolfingrip.report.page.content import Page


@dataclass(frozen=True, slots=True)
class FoundResult:
    """A folder with a result.

    Attributes:
        kind: a key of :attr:`Contribution.marks`.
        folder: where it is.
    """

    kind: str
    folder: Path


@dataclass(frozen=True, slots=True)
class Given:
    """Data that a page is made with, besides the results.

    Attributes:
        measured: columns of a measurement, drawn beside the curves.
        pictures: whether pictures are rendered that stand in place of the 3D view.
        say: called with a line on what is being read.
    """

    measured: Columns | None = None
    pictures: bool = True
    say: Callable[[str], None] = lambda text: None


class Contribution(ABC):
    """Part of a page that one kind of result adds.

    Attributes:
        marks: name of each kind, and the file by which it is known.
        titles: what each kind is called in the title of a page.
        place: order on the page; of two files in a folder, the one with the lower place counts.
    """

    marks: ClassVar[Mapping[str, str]]
    titles: ClassVar[Mapping[str, str]] = {}
    place: ClassVar[int]

    @abstractmethod
    def add(self, page: Page, found: Sequence[FoundResult], given: Given) -> list[str]:
        """Add the results of these kinds to a page.

        Args:
            page: what it shows so far.
            found: at least one result.
            given: what else it is made with.

        Returns:
            Names of the results, for the page's title.

        Raises:
            ResultFileError: one line, if a result cannot be read.
            ConfigError: one line, if its configuration cannot.
        """

    def named(self, found: Sequence[FoundResult]) -> list[str]:
        """The titles of these results' kinds."""
        return [self.titles[each.kind] for each in found]
