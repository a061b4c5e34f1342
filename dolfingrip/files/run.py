"""``run.json``: all that is needed to repeat a run and to judge it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar, Literal

from pydantic import Field

from dolfingrip.files.result_file import Part, ResultFile


@dataclass(frozen=True, slots=True)
class PlatePose:
    """A point of the rigid plane (mm) and its normal towards the finger."""

    point_mm: tuple[float, float, float]
    normal: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class TurningPoint:
    """The point at which the two straight lines that fit the blocked-force curve best meet.

    Attributes:
        pressure_kPa: pressure at which the lines meet.
        force_N: force at which the lines meet.
        slope_before_N_per_kPa: slope of the first line.
        slope_after_N_per_kPa: slope of the second line.
        touch_kPa: pressure at which the first bellows touch; None if none touch.
        touching: names of the first bellows that touch; None if none touch.
    """

    pressure_kPa: float
    force_N: float
    slope_before_N_per_kPa: float
    slope_after_N_per_kPa: float
    touch_kPa: float | None = None
    touching: str | None = None

    def sentence(self) -> str:
        """A sentence with the turning point, the slopes and the first touch."""
        return (
            f"turning point at {self.pressure_kPa:.0f} kPa, {self.force_N:.2f} N: slope "
            f"{self.slope_before_N_per_kPa:.4f} N/kPa before, "
            f"{self.slope_after_N_per_kPa:.4f} N/kPa after; {self.touch}"
        )

    @property
    def touch(self) -> str:
        """The first touch of bellows, in words."""
        if self.touch_kPa is None:
            return "no touch of neighbours was found"
        return f"first to touch: {self.touching}, at {self.touch_kPa:.0f} kPa"


class GraspKind(StrEnum):
    """The classes of a grasp's outcome."""

    PICKED_UP = "picked up"
    SLIPPED = "slipped"
    DROPPED = "dropped"
    EJECTED = "ejected"
    NOT_LIFTED = "not lifted"


@dataclass(frozen=True, slots=True)
class GraspOutcome:
    """The class of a grasp, with its time and a sentence.

    Attributes:
        kind: the class.
        time_s: when it was decided.
        sentence: what happened.
    """

    kind: GraspKind
    time_s: float
    sentence: str


class RunFailure(Part):
    """Why a run ended early."""

    kind: str = Field(description="class of the failure; interrupted, or error of the program")
    last_good: dict[str, float] = Field(description="controls of the last converged state")
    said: str = Field(alias="sentence", description="in words")

    def sentence(self) -> str:
        """The failure in words."""
        return self.said


class MeshCounts(Part):
    """The mesh of a run."""

    elements: int = 0
    dofs: int = 0
    half: bool = Field(False, description="whether it is that of half a specimen")
    single_walls: float = Field(
        0.0, description="part of the elements on a cavity that lie on the skin, too"
    )


class MeshCheck(Part):
    """The error of readings that is due to the mesh: reading less that of an ever finer mesh."""

    errors: dict[str, tuple[float, ...]] = Field(
        {}, description="by column, one for each row, in the column's unit"
    )
    why: str = Field("", description="why none can be told; empty where one can")
    reasons: dict[str, str] = Field({}, description="by column, why its error cannot be told")
    wall_s: float = 0.0

    def reason(self, column: str) -> str:
        """Why the error of a column cannot be told, in words."""
        return self.reasons.get(column, self.why)


class SolverCounts(Part):
    """How often the solver did what."""

    iterations: int = 0
    factorisations: int = 0
    load_steps: int = 0
    damped_steps: int = 0
    linear_solver: Literal["direct", "iterative"] = "direct"
    factors: Literal["CHOLMOD", "MUMPS"] | None = Field(
        None, description="what factorised definite tangents"
    )
    matrix_patterns: int = 1


class PluginUsed(Part):
    """A plugin of the process that ran."""

    module: str
    path: str
    digest: str = Field(description="SHA-256 of its file")
    version: str = Field("", description="of the installed package; empty for a file")


class RunFile(ResultFile):
    """Contents of ``run.json``."""

    FILE: ClassVar[str] = "run.json"
    MADE_BY: ClassVar[str] = "the experiment's command"

    schema_version: Literal[1] = 1
    command: tuple[str, ...] = Field((), description="arguments of dolfingrip")
    config: dict[str, Any] = Field({}, description="resolved; --config run.json takes it")
    experiment: str
    complete: bool = Field(False, description="whether the path came to its end")
    mesh: MeshCounts = MeshCounts()
    mesh_check: MeshCheck | None = Field(None, description="null: it was not made")
    bands: dict[str, float] = Field({}, description="standard deviations that bands are made of")
    newton: SolverCounts = SolverCounts()
    failure: RunFailure | None = None
    notes: tuple[str, ...] = Field((), description="doubts about the configuration")
    turning_point: TurningPoint | None = None
    outcome: GraspOutcome | None = None
    plate: PlatePose | None = Field(None, description="where the force sensor stood")
    sag_mm: tuple[float, float, float] | None = Field(
        None, description="mean displacement of the tip's face by weight, from the shape as built"
    )
    second_runs: dict[str, str] = Field({}, description="how those for choices of the model ended")
    ranks: int | None = None
    compiled_for: str = ""
    wall_s: float | None = Field(None, description="null: it has not ended")
    memory_forecast_MB: int | None = None
    peak_memory_MB: int | None = None
    profile: dict[str, Any] = Field({}, description="time of each phase in s")
    versions: dict[str, str] = Field({}, description="of the software")
    plugins: tuple[PluginUsed, ...] = Field((), description="laws, effects … of the user's own")
    machine: dict[str, Any] = Field({}, description="system, and number of processors")
