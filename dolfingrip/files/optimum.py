"""``optimum.json``: the front of a surrogate, and the designs that are chosen along it."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from pydantic import Field

from dolfingrip.files.objective import NamedObjective
from dolfingrip.files.result_file import Part, ResultFile


class ChosenDesign(Part):
    """A design worth a look."""

    role: str = Field(description="chosen, polished or original")
    limit: float | None = Field(None, description="of the first objective, that it was chosen by")
    inputs: dict[str, float]
    surrogate: dict[str, float] = Field({}, description="the surrogate's outputs")
    resolved: bool = Field(False, description="whether finite elements were asked")
    fem: dict[str, float] | None = Field(None, description="outputs by finite elements")
    failure: str = ""
    within_limit: bool | None = Field(None, description="whether it is, by finite elements")
    gain: float | None = Field(
        None, description="second objective by that of the original, less 1, by finite elements"
    )


class FrontDesign(Part):
    """A point of the surrogate's front."""

    inputs: dict[str, float]
    surrogate: dict[str, float]
    fem: dict[str, float] | None = Field(None, description="null: not computed again, or failed")
    failure: str = ""


class SurrogateError(Part):
    """The surrogate's error on designs along the front."""

    designs: int
    rms: float = Field(description="root mean square, in the output's unit")
    largest: float
    relative: float = Field(description="rms by the mean size of the output")


class OptimumFile(ResultFile):
    """Contents of ``optimum.json``."""

    FILE: ClassVar[str] = "optimum.json"
    MADE_BY: ClassVar[str] = "dolfingrip optimise"

    schema_version: Literal[2] = 2
    objectives: tuple[NamedObjective, NamedObjective]
    settings: dict[str, Any] = Field(description="of NSGA-II")
    surrogate_sha256: str
    front: tuple[FrontDesign, ...] = Field(description="by the rising first objective")
    limits_below_the_front: tuple[float, ...] = ()
    designs: tuple[ChosenDesign, ...]
    surrogate_error_on_front: dict[str, SurrogateError] = Field({}, description="by output")
    versions: dict[str, str] = Field({}, description="of the software")
