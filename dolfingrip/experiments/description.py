"""The description of an experiment, for its command and for the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Column:
    """A column of the table that is printed.

    Attributes:
        name: of the result's column, with its unit.
        heading: above the column.
        form: format of a number, as ``.2f``.
    """

    name: str
    heading: str
    form: str


@dataclass(frozen=True, slots=True)
class Curve:
    """A line of a plot: the result's column, and what the legend calls it."""

    column: str
    label: str


@dataclass(frozen=True, slots=True)
class Plot:
    """What is drawn of a result.

    Attributes:
        label: of the vertical axis.
        curves: the first one must be there; the others are drawn where they are.
        over: column of the horizontal axis.
        over_label: of the horizontal axis.
    """

    label: str
    curves: tuple[Curve, ...]
    over: str = "pressure_kPa"
    over_label: str = "Pressure (kPa)"


@dataclass(frozen=True, slots=True)
class Option:
    """An option that the command of one experiment has besides those of all.

    Attributes:
        flag: on the command line.
        type: of its value; ``bool`` for one without a value, a list for one that can be repeated.
        default: where it is not given; None leaves the configuration's.
        help: one line.
        key: of the configuration, which it sets; "" where the experiment itself looks at it.
    """

    flag: str
    type: Any
    default: object
    help: str
    key: str = ""

    @property
    def name(self) -> str:
        """The flag as a name of Python."""
        return self.flag.lstrip("-").replace("-", "_")


PRESSURE = Column("pressure_kPa", "Pressure (kPa)", "g")
