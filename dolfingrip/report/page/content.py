"""What a page shows, as plain data: numbers, checks, charts, scenes. Nothing here knows HTML.

Each kind of result contributes to a page by a class of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from dolfingrip.charts.chart import Axis, Chart
from dolfingrip.files.table import Columns
from dolfingrip.files.text_table import TextTable

Verdict = Literal["pass", "fail", "open", ""]
"""Of a number or a check; "open" if it was not checked, "" if there is nothing to check."""


@dataclass(frozen=True, slots=True)
class KeyNumber:
    """One of the numbers that a reader sees first.

    Attributes:
        name: what it is.
        value: with its unit.
        verdict: whether it passes.
        said: the verdict in words.
    """

    name: str
    value: str
    verdict: Verdict = ""
    said: str = ""


@dataclass(frozen=True, slots=True)
class Check:
    """One row of "Can I trust it?".

    Attributes:
        name: what was checked, and of which result.
        value: what was found, with its unit; "–" if it was not checked.
        goal: what it must be.
        verdict: whether it is so.
        said: the verdict in words.
    """

    name: str
    value: str
    goal: str
    verdict: Verdict
    said: str


@dataclass(frozen=True, slots=True)
class DiagnosisPart:
    """The section on a diagnosis.

    Attributes:
        answer: line with which the section begins.
        lines: the lines below it: how sure it is, and what to measure next.
        bars: chart of the causes' probabilities.
        charts: measured against simulated, with residuals below.
        tables: what causes explain, before and after, and the like.
        unexplained: sentences on what stays unexplained, and where.
    """

    title: str
    answer: str
    lines: Sequence[str]
    bars: Chart
    charts: Sequence[Chart] = ()
    tables: Sequence[TextTable] = ()
    unexplained: Sequence[str] = ()


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """A design in the plane of two objectives.

    Attributes:
        label: its name.
        group: "design" (of experiments), "front" (of the surrogate), "chosen", "original".
        rows: its parameters and outputs as text, uncertainties included.
        model: number of its shape among the front's models; None: it has none.
        inputs: values of its parameters by key.
    """

    label: str
    x: float
    y: float
    group: str
    rows: Sequence[tuple[str, str]]
    model: int | None = None
    inputs: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Front:
    """Designs, the surrogate's front through them, and their shapes.

    Attributes:
        x, y: axes.
        points: designs.
        line: coordinates of the front, shape (points,) each; None: there is none.
        models: packed scenes of one step.
        start: number of the point that is shown first.
        said: sentences on what is drawn.
    """

    title: str
    x: Axis
    y: Axis
    points: Sequence[FrontPoint]
    line: tuple[Sequence[float], Sequence[float]] | None
    models: Sequence[dict[str, Any]]
    start: int
    said: Sequence[str]


@dataclass(frozen=True, slots=True)
class Source:
    """Where something of the page comes from, for the section on provenance.

    Attributes:
        title: of the result.
        folder: where it was read.
        again: command that computes it again.
        facts: names and values, such as versions.
        files: titles and contents that are shown when asked for, such as the configuration.
    """

    title: str
    folder: str
    again: str
    facts: Sequence[tuple[str, str]] = ()
    files: Sequence[tuple[str, str]] = ()


@dataclass(slots=True)
class Page:
    """Everything on a page, in the order of reading."""

    title: str
    conditions: str = ""
    numbers: list[KeyNumber] = field(default_factory=list)
    scenes: list[dict[str, Any]] = field(default_factory=list)
    stills: list[tuple[str, bytes]] = field(default_factory=list)
    charts: list[Chart] = field(default_factory=list)
    front: Front | None = None
    tables: list[TextTable] = field(default_factory=list)
    code: list[tuple[str, str]] = field(default_factory=list)
    diagnoses: list[DiagnosisPart] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    sources: list[Source] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def plain(value: Any) -> Any:
    """Data as JSON has it: no arrays, no NaN, floats of six digits."""
    if isinstance(value, np.ndarray):
        return [plain(entry) for entry in value.tolist()]
    if isinstance(value, float | np.floating):
        return float(f"{value:.6g}") if np.isfinite(value) else None
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return value


def as_data(item: Any) -> dict[str, Any]:
    """A dataclass of this file as JSON has it."""
    fields: dict[str, Any] = plain(asdict(item))
    return fields


@dataclass(frozen=True, slots=True)
class FoundResult:
    """A folder with a result.

    Attributes:
        kind: a key of :attr:`Contribution.marks`.
        folder: where it is.
        inside: whether it belongs to the result whose folder it lies in.
    """

    kind: str
    folder: Path
    inside: bool = False


class Contribution:
    """Part of a page that one kind of result adds.

    Attributes:
        marks: name of each kind, and the file by which it is known.
        titles: what each kind is called in the title of a page.
        place: order on the page; of two files in a folder, the one with the lower place counts.
        inside: folders in that of a result that hold results which belong to it.
    """

    marks: ClassVar[Mapping[str, str]]
    titles: ClassVar[Mapping[str, str]] = {}
    inside: ClassVar[Sequence[str]] = ()
    place: ClassVar[int]

    def add(
        self, page: Page, results: Sequence[FoundResult], measured: Columns | None
    ) -> list[str]:
        """Add the results of these kinds to a page, one after the other.

        Args:
            page: what it shows so far.
            results: at least one result.
            measured: columns of a measurement, drawn beside the curves; None: there is none.

        Returns:
            Names of the results, for the page's title.

        Raises:
            ResultFileError: one line, if a result cannot be read.
            ConfigError: one line, if its configuration cannot.
        """
        for result in results:
            self.show(page, result)
        return [self.titles[result.kind] for result in results]

    def show(self, page: Page, result: FoundResult) -> None:
        """Add one result to a page.

        Args:
            page: what it shows so far.
            result: the result.
        """
        raise NotImplementedError
