"""Section of the configuration for the line whose rotation a camera measures."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field, model_validator

from dolfingrip.sections.section import Role, Section, Vector, outside


class Camera(Section):
    """The line whose rotation from rest is the chord's angle, atan(−u_x/(L + u_z))."""

    role: ClassVar = Role.INSTRUMENT
    felt_by: ClassVar = ("finger",)

    chord: Literal["centres", "back edges", "points"] = Field(
        "centres",
        description="from the clamped face's centre to the tip's, between the edges that the back "
        "(lowest x) has at clamp and tip, or between two points",
    )
    from_mm: Vector | None = Field(None, description="points: where the line begins, as meshed")
    to_mm: Vector | None = Field(None, description="points: where it ends, as meshed")

    @model_validator(mode="after")
    def _points(self) -> Camera:
        for key in ("from_mm", "to_mm"):
            value = getattr(self, key)
            if self.chord == "points" and value is None:
                raise outside(key, "none", 'allowed with chord = "points": three numbers')
            if self.chord != "points" and value is not None:
                raise outside(key, list(value), 'allowed: with chord = "points"')
        if self.from_mm is not None and self.from_mm == self.to_mm:
            raise outside("to_mm", list(self.from_mm), "allowed: another point than from_mm")
        return self
