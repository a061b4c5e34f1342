"""``design.json``: the design that a descent or a search found."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Final, Literal

from pydantic import BaseModel, Field, model_validator

from dolfingrip.files.result_file import Part, ResultFile
from dolfingrip.files.text_table import TextTable

RUNS: Final = ("start", "design")
"""Folders beside the file, with a run of the start and one of the design, as any run writes it."""

MARKERS: Final = 24
"""Markers of these runs on the back's middle line, where a curve is followed."""

CURVE_SQUARE = "curve_mean_square_mm2"
"""Name of the objective of a curve, which is ``channels.CURVE``'s."""

CURVE_RMS = "curve_rms_mm"
"""Name under which people see the objective of a curve: the root of its mean square."""


def as_shown(quantity: str, value: float) -> float:
    """Return an objective as people see it.

    Args:
        quantity: its name.
        value: in the unit of its name.

    Returns:
        The root mean square distance from a curve (mm) for its mean square; else the value.
    """
    return math.sqrt(value) if quantity == CURVE_SQUARE else value


def named(words: str) -> str:
    """Return words about an objective with the name under which people see it.

    Args:
        words: that may have the name of a mean square.
    """
    return words.replace(CURVE_SQUARE, CURVE_RMS)


class DesignConstraint(Part):
    """A limit of the design."""

    of: str = Field(description="quantity, with its unit in the name")
    sense: Literal["at most", "at least"]
    limit: float
    start: float | None = None
    value: float
    kept: bool


class DesignParameter(Part):
    """A parameter of the design."""

    start: float
    value: float
    low: float
    high: float


class ConditionObjective(Part):
    """The objective under one condition."""

    condition: str
    start: float
    objective: float


class RefinedDesign(Part):
    """Start and design on a finer mesh."""

    objective: float | None = Field(None, description="null: it was not solved")
    start: float | None = None
    gain: float | None = None
    constraints: dict[str, tuple[float, ...]] = Field({}, description="at start and design")
    failure: str = ""
    simulations: int = 0


class DesignStart(Part):
    """A descent from one of several starts."""

    ending: str
    start: float | None = None
    objective: float | None = Field(None, description="null: it has no design")
    simulations: int = 0
    as_good: bool = False


class MatchedCurve(Part):
    """How near the back's middle line comes to the curve that it shall follow."""

    rms_mm: float
    start_rms_mm: float
    stops_mm_per_unit: dict[str, float] = Field(
        {}, description="by parameter at its bound: how much nearer one unit more would bring it"
    )
    tied: dict[str, dict[str, float]] = Field(
        {},
        description="by parameter that the curve does not determine: how much others change for "
        "each unit of it, so that a finger lies along the curve as before",
    )


class DesignFile(ResultFile):
    """Contents of ``design.json``."""

    FILE: ClassVar[str] = "design.json"
    MADE_BY: ClassVar[str] = "dolfingrip design"

    schema_version: Literal[1] = 1
    of: str = Field(description="what is improved, in words: minimise or maximise …")
    quantity: str = Field("", description="name of what is improved, with its unit")
    objective: float = Field(description="of the design, in the unit of its name")
    start: float = Field(description="of the start")
    gain: float | None = Field(None, description="null: the start's is nothing")
    constraints: tuple[DesignConstraint, ...] = ()
    simulations: int = Field(description="load paths")
    designs: int = 0
    failed_designs: int = 0
    ending: str = Field(description="why it ended")
    wall_s: float | None = None
    simulations_s: float | None = None
    conditions: tuple[str, ...] = ()
    by_condition: tuple[ConditionObjective, ...] = ()
    parameters: dict[str, DesignParameter]
    refined: RefinedDesign | None = None
    matched: MatchedCurve | None = None
    starts: tuple[DesignStart, ...] = ()
    differ: dict[str, tuple[float, float]] | None = Field(
        None, description="range of what differs between the best designs of several starts"
    )

    @model_validator(mode="before")
    @classmethod
    def _name_quantity(cls, given: Any) -> Any:
        """Files of earlier versions name the quantity in ``of`` alone, after the first word."""
        words = str(given.get("of", "")).split() if isinstance(given, dict) else []
        return {"quantity": words[1], **given} if len(words) > 1 else given

    def tables(self) -> list[TextTable]:
        """List parameters, and constraints where there are some, as tables."""
        rows = [
            [name, f"{param.start:.4g}", f"{param.value:.4g}", f"{param.low:g} to {param.high:g}"]
            for name, param in self.parameters.items()
        ]
        headings = ["Parameter", "Start", "Found", "Allowed"]
        tables = [TextTable(headings, rows, "Parameters of the design")]
        if self.constraints:
            limits = [
                [bound.of, f"{bound.value:.4g}", f"{bound.sense} {bound.limit:g}",
                 "kept" if bound.kept else "not kept"]
                for bound in self.constraints
            ]  # fmt: skip
            headings = ["Constraint", "Found", "Allowed", ""]
            tables.append(TextTable(headings, limits, "Constraints of the design"))
        return tables

    @property
    def shown(self) -> DesignFile:
        """A copy for people, in which a curve's mean squares are root mean squares in mm."""
        if self.quantity != CURVE_SQUARE:
            return self
        return _rooted(self).model_copy(
            update={
                "of": named(self.of),
                "quantity": named(self.quantity),
                "by_condition": tuple(map(_rooted, self.by_condition)),
                "refined": self.refined and _rooted(self.refined),
                "starts": tuple(map(_rooted, self.starts)),
            }
        )


def _rooted[P: BaseModel](part: P) -> P:
    """A part with the roots of its objectives, and the gain of these."""
    squares = {name: getattr(part, name) for name in ("start", "objective")}
    roots = {name: value if value is None else math.sqrt(value) for name, value in squares.items()}
    if (gain := getattr(part, "gain", None)) is not None:
        roots["gain"] = math.sqrt(1 + gain) - 1
    return part.model_copy(update=roots)
