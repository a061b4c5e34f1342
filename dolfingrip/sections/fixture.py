"""Sections of the configuration for the surroundings of the finger: plate, gravity."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field, model_validator

from dolfingrip.sections.section import FINGERS, Entry, Role, Section, Vector, outside


class Plate(Section):
    """The force sensor: a rigid plane facing the base layer's back near the tip."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = ("plate",)
    entry: ClassVar = {"gap_mm": Entry.POSE, "tilt_deg": Entry.POSE}

    gap_mm: float = Field(
        0.0, ge=0, description="skin to plate, from the finger at rest: unpressurised, hanging"
    )
    tilt_deg: float = Field(0.0, gt=-80, lt=80, description="rotation of the plate about y")
    normal: Vector = Field((1.0, 0.0, 0.0), description="of the untilted plate, towards the finger")
    contact_length_mm: float = Field(10.0, gt=0, description="length of finger facing it, from tip")
    barrier_mm: float = Field(0.1, gt=0, le=10, description="distance at which contact is felt")
    stiffness_MPa: float = Field(0.1, gt=0, description="of the barrier")

    @model_validator(mode="after")
    def _direction(self) -> Plate:
        if not any(self.normal):
            raise outside("normal", list(self.normal), "allowed: any vector but zero")
        return self


class Gravity(Section):
    """Dead weight of the finger; off by default, as in the paper."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = FINGERS
    entry: ClassVar = {"acceleration_m_s2": Entry.CONSTANT}  # gravity_pitch changes the direction

    acceleration_m_s2: float = Field(0.0, ge=0, le=1000, description="9.81 switches gravity on")
    direction: Vector = Field((0.0, 0.0, 1.0), description="z is from clamp to tip")

    def movable(self, key: str) -> bool:
        """Return whether gravity is on."""
        return bool(self.acceleration_m_s2)

    @model_validator(mode="after")
    def _direction(self) -> Gravity:
        if not any(self.direction):
            raise outside("direction", list(self.direction), "allowed: any vector but zero")
        return self
