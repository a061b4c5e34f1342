"""A chart as plain data: axes with units, series, bands, marks and notes.

``picture`` draws charts with Matplotlib; ``report.page.html`` writes them for a page's script.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

Style = Literal["line", "dash", "dots", "points", "bar"]
"""How a series is drawn."""

Colour = str
"""Name of a colour in ``picture.COLOURS``; "": the next one that no series of the chart has."""

Numbers = Sequence[float] | npt.NDArray[Any]


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis of a chart.

    Attributes:
        label: with the unit.
        unit: alone, as printed.
        short: label without the unit.
        ends: values at the ends of the axis; None: those of the series.
        log: whether the scale is logarithmic.
        zero: whether the axis begins at zero unless values lie below it.
        whole: whether all values are whole numbers.
        names: of places 0, 1, 2, … in place of numbers, for bars.
    """

    label: str
    unit: str = ""
    short: str = ""
    ends: tuple[float | None, float | None] | None = None
    log: bool = False
    zero: bool = False
    whole: bool = False
    names: Sequence[str] = ()


@dataclass(frozen=True, slots=True)
class Series:
    """A curve, points, a band, or bars.

    Attributes:
        name: in the key and beside the pointer; "": it is part of the series before it.
        x, y: shape (points,); NaN makes a gap. Of bars ``y`` is the place and ``x`` the length.
        style: how it is drawn.
        scene: number of the scene whose steps the points are, if they are.
        low, high: ends of a curve's band or of points' error bars, in y, or of the intervals of
            bars, in x; shape (points,).
        branches: branch of each point, such as "loading"; each has a line style of its own.
        colour: name of its colour.
        marker: Matplotlib's name of its marks; "": points have the usual ones, lines none.
        said: texts at the ends of bars.
    """

    name: str
    x: Numbers
    y: Numbers
    style: Style = "line"
    scene: int | None = None
    low: Numbers | None = None
    high: Numbers | None = None
    branches: Sequence[str] | None = None
    colour: Colour = ""
    marker: str = ""
    said: Sequence[str] = ()


@dataclass(frozen=True, slots=True)
class Mark:
    """A straight line across a chart, or a span of one of its axes.

    Attributes:
        at: value on the axis.
        label: in the key, or along the line.
        axis: whose value it is.
        to: end of a span that is shaded; None: it is a line.
        colour: name of its colour.
        beside: whether the label stands along the line, in place of the key.
    """

    at: float
    label: str = ""
    axis: Literal["x", "y"] = "y"
    to: float | None = None
    colour: Colour = "ink"
    beside: bool = False


@dataclass(frozen=True, slots=True)
class Chart:
    """Series over one axis, or bars.

    Attributes:
        title: what it shows, in words.
        x, y: axes.
        series: in the order in which they are drawn.
        marks: lines and spans.
        note: a sentence below it.
        alt: description for those who cannot see it; "": made of title and axes.
        equal: whether both axes have the same scale.
        below: chart that stands under it on the same horizontal axis, such as its residuals.
    """

    title: str
    x: Axis
    y: Axis
    series: Sequence[Series]
    marks: Sequence[Mark] = ()
    note: str = ""
    alt: str = ""
    equal: bool = False
    below: Chart | None = None

    @property
    def description(self) -> str:
        """The chart in words."""
        shown = f"{self.title}: {self.y.label} over {self.x.label}"
        return self.alt or f"{shown}. The table below has the numbers."


def runs(mask: Any) -> Iterator[slice]:
    """Find consecutive True values.

    Args:
        mask: shape (n,).

    Yields:
        The slice of each group of them.
    """
    steps = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    for first, last in zip(steps[::2], steps[1::2], strict=True):
        yield slice(int(first), int(last))
