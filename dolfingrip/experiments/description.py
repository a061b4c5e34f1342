"""The description of an experiment, for its command and for the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from dolfingrip.channels import PRESSURE, Channel


@dataclass(frozen=True, slots=True)
class Curve:
    """A line of a plot: the result's column, and what the legend calls it."""

    column: str
    label: str


@dataclass(frozen=True, slots=True)
class Plot:
    """The plot of a result.

    Attributes:
        label: label of the vertical axis.
        curves: the first curve must be in the result; the others are drawn if they are.
        over: what the horizontal axis shows.
    """

    label: str
    curves: tuple[Curve, ...]
    over: Channel = PRESSURE


@dataclass(frozen=True, slots=True)
class Option:
    """An option that the command of one experiment has in addition to the common options.

    Attributes:
        flag: name on the command line.
        type: type of its value; ``bool`` for a flag without value, a list if it can be repeated.
        default: value if it is not given; None leaves the configuration as it is.
        help: one line.
        key: key of the configuration that it sets; "" if the experiment itself reads the option.
        needs: the option that it is allowed with, and its value in words.
    """

    flag: str
    type: Any
    default: object
    help: str
    key: str = ""
    needs: str = ""

    @property
    def name(self) -> str:
        """The flag as a Python name."""
        return self.flag.lstrip("-").replace("-", "_")


PRESSURE_OPTION: Final = Option(
    "--pressure",
    float,
    None,
    "Highest pressure; below 0: suction alone.",
    "experiment.max_pressure_kPa",
)
"""The option of all experiments that pressurise."""

SUCTION_OPTION: Final = Option(
    "--min-pressure",
    float,
    None,
    "Suction before the highest pressure, such as -60.",
    "experiment.min_pressure_kPa",
)
"""The option of all experiments that may begin with suction."""

DYNAMIC_OPTION: Final = Option(
    "--dynamic",
    bool,
    None,
    "With inertia, in the time of ramps and waits.",
    "experiment.dynamic",
)
"""The option of all experiments on a finger that may move in time."""
