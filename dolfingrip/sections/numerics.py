"""Sections of the configuration for the solution: Newton's method, contact."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Literal

from pydantic import Field

from dolfingrip.sections.section import FINGERS, Ratio, Refusal, Role, Section


class Solver(Section):
    """Discretisation and Newton's method."""

    role: ClassVar = Role.NUMERICS
    effort: ClassVar = ("time_limit_s", "linear", "memory_GB")
    later: ClassVar = {"time_error_mm": 0.01, "hht_alpha": -0.05}

    element: Literal["P1", "P2", "P2-P1", "S2"] | None = Field(
        None,
        description="displacement: P1 or P2 on tetrahedra, P2-P1 with a linear pressure for nu "
        "near 0.5, S2 on hexahedra (20 nodes, 8 integration points); default: S2, or P2 on "
        "tetrahedra of a file or by number",
    )
    integration: Literal["reduced", "full", "selective"] | None = Field(
        None,
        description="of hexahedra: 8 points; 27, which pressures near the shear modulus need; or "
        "27, and 8 for the change of volume, which locks at 27 where nu is near 0.5; default: "
        "reduced for bellows and mesh files, selective for other kinds of geometry",
    )
    linear: Literal["auto", "direct", "iterative"] = Field(
        "auto",
        description="linear systems: a factorisation; multigrid of elements P2 and S2; or auto, "
        "multigrid from 120,000 unknowns of P2 on, and from 400,000 of S2",
    )
    memory_GB: float | None = Field(
        None, gt=0, description="largest memory that a run may need; default: what is free"
    )
    rtol: Ratio = Field(
        1e-6, ge=1e-30, le=0.1, description="residual, relative to the step's first"
    )
    atol_N: float = Field(1e-9, ge=1e-30, le=1e-4, description="residual, absolute (N)")
    max_iterations: int = Field(
        30, ge=1, le=1000, description="Newton iterations a step, three times as many where damped"
    )
    max_step_kPa: float = Field(25.0, gt=0, description="largest pressure step")
    max_step_s: float | None = Field(
        None,
        gt=0,
        description="largest step in time; default: as the pressure's allows, dynamic 0.02 s",
    )
    time_error_mm: float = Field(
        0.01, ge=1e-6, le=10, description="dynamic: error of a step in time, which sets its length"
    )
    hht_alpha: Ratio = Field(
        -0.05,
        ge=-1 / 3,
        le=0,
        description="dynamic: damping of what steps do not resolve; 0: Newmark's scheme without",
    )
    min_step_kPa: float = Field(0.1, gt=0, description="smallest step before a failure is called")
    time_limit_s: float | None = Field(
        None, gt=0, description="of a load path, which then ends at its last good pressure"
    )
    mixed_integration_point: bool = Field(
        True, description="carry the stress as an independent field (fewer iterations)"
    )

    @property
    def shortest_step(self) -> float:
        """The smallest step before a failure is called, as part of the longest."""
        return self.min_step_kPa / self.max_step_kPa

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        yield from self.up_to("min_step_kPa", "max_step_kPa")


class Contact(Section):
    """Barrier contact (incremental potential contact) of the outer skin with itself."""

    role: ClassVar = Role.NUMERICS
    felt_by: ClassVar = FINGERS

    self_contact: bool = Field(True, description="bellows cannot pass through one another")
    barrier_mm: float = Field(0.2, gt=0, le=10, description="distance at which contact is felt")
    stiffness_MPa: float = Field(0.005, gt=0, description="of the barrier")
    spacing_mm: float = Field(
        2.0, gt=0, le=100, description="hexahedra: largest distance of contact points"
    )
