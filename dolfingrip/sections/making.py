"""Sections of the configuration for what makes a finger: its air inlet, and a mould's walls."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Final, Literal

from pydantic import Field

from dolfingrip.sections.section import Refusal, Role, Section

LEAST_WALL_MM: Final = 1.2
"""Thickness from which printers print a wall that holds: three lines of a nozzle of 0.4 mm."""


class Inlet(Section):
    """The connector that ``export`` adds to each cavity; a simulation leaves it out."""

    role: ClassVar = Role.BODY
    felt_by: ClassVar = ()

    kind: Literal["barb", "tube"] = Field("barb", description="barbs hold a hose; a tube is plain")
    place: Literal["clamp", "side"] = Field(
        "clamp", description="the face z = 0, or the side y > 0 of the clamped block"
    )
    bore_mm: float = Field(2.0, gt=0, le=50, description="inner diameter")
    wall_mm: float = Field(1.6, ge=LEAST_WALL_MM, le=50, description="around the bore")
    length_mm: float = Field(12.0, gt=0, le=200, description="beyond the face")
    barb_mm: float = Field(0.6, gt=0, le=5, description="height of the barbs above the tube")
    x_mm: float | None = Field(
        None, gt=0, le=1000, description="axis above the contact face; default: amid the cavity"
    )
    z_mm: float | None = Field(
        None, gt=0, le=1000, description="side: axis from the clamp; default: half way to the air"
    )

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        if self.place == "clamp" and self.z_mm is not None:
            yield Refusal("z_mm", 'allowed: with place = "side"')


class Mould(Section):
    """The mould that ``export --mould`` writes for cast kinds of geometry."""

    role: ClassVar = Role.PROCEDURE
    felt_by: ClassVar = ()

    thickness_mm: float = Field(
        4.0, ge=LEAST_WALL_MM, le=100, description="of walls, plate, rim and tray"
    )
    draft_deg: float = Field(
        1.0, ge=0, le=10, description="of faces along which parts are pulled; walls keep their mean"
    )
    split_mm: float = Field(0.0, description="plane y at which the two halves meet")
    clearance_mm: float = Field(
        0.2, ge=0, le=2, description="between the halves and the core plate's rim around them"
    )
