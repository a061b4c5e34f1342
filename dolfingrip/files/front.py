"""``front.json``: a front that gradients found, with its uncertainty."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from dolfingrip.files.objective import NamedObjective
from dolfingrip.files.result_file import Part, ResultFile


class FrontLevel(Part):
    """The best design for one limit."""

    limit: float = Field(description="of the first objective, in its unit")
    mean: float = Field(description="second objective there")
    deviation: float = Field(description="its standard deviation")
    inputs: dict[str, tuple[float, float, float]] = Field(
        description="of each parameter the best value and its central 90 %"
    )


class SimulatedDesign(Part):
    """A design that was simulated on the way."""

    inputs: dict[str, float]
    values: tuple[float, float] = Field(description="both objectives")


class FrontFile(ResultFile):
    """Contents of ``front.json``."""

    FILE: ClassVar[str] = "front.json"
    MADE_BY: ClassVar[str] = "dolfingrip design"

    schema_version: Literal[2] = 2
    objectives: tuple[NamedObjective, NamedObjective] = Field(
        description="the one that is limited, then the one that is improved"
    )
    ranges: dict[str, tuple[float, float]] = Field(description="allowed values of each parameter")
    levels: tuple[FrontLevel, ...]
    simulated: tuple[SimulatedDesign, ...]
    simulations: int = Field(description="load paths, failed ones included")
    failed: int
    hypervolumes: tuple[float | None, ...] = Field(description="after each simulation")
    unsure: tuple[float | None, ...] = Field(
        description="largest deviation after each simulation, as a part of the objective's range"
    )
    wall_s: float
