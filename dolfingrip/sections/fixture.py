"""Sections of the configuration for what surrounds the finger: plate, gravity, camera."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Le
from pydantic import Field

from dolfingrip.sections.ranges import PURE
from dolfingrip.sections.section import FINGERS, Entry, Refusal, Role, Section, Vector

Place = Annotated[tuple[float, float], Field(strict=False)]
"""x and z (mm) of a point of the finger at rest."""


class PlateSettings(Section):
    """The force sensor: a rigid plane facing the base layer's back near the tip."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = ("plate",)
    entry: ClassVar = {"gap_mm": Entry.POSE, "tilt_deg": Entry.POSE}

    gap_mm: float = Field(
        0.0, ge=0, description="skin to plate, from the finger at rest: unpressurised, hanging"
    )
    tilt_deg: float = Field(0.0, gt=-80, lt=80, description="rotation of the plate about y")
    normal: Annotated[Vector, PURE] = Field(
        (1.0, 0.0, 0.0), description="of the untilted plate, towards the finger"
    )
    contact_length_mm: float = Field(10.0, gt=0, description="length of finger facing it, from tip")
    barrier_mm: float = Field(0.1, gt=0, le=10, description="distance at which contact is felt")
    stiffness_MPa: float = Field(0.1, gt=0, description="of the barrier")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        yield from self.directed("normal")


class Gravity(Section):
    """Dead weight of the finger; off by default, as in the paper."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = FINGERS
    entry: ClassVar = {"acceleration_m_s2": Entry.CONSTANT}  # gravity_pitch changes the direction
    FALLS: ClassVar = "gravity.falls_mm_s2"
    """Name of a model's constant for :attr:`falls_mm_s2`."""

    acceleration_m_s2: float = Field(0.0, ge=0, le=1000, description="9.81 switches gravity on")
    direction: Annotated[Vector, PURE] = Field(
        (0.0, 0.0, 1.0), description="z is from clamp to tip"
    )

    @property
    def falls_mm_s2(self) -> np.ndarray:
        """Acceleration of what falls freely, (3,)."""
        direction = np.asarray(self.direction, dtype=float)
        return 1000 * self.acceleration_m_s2 * direction / np.linalg.norm(direction)

    def movable(self, key: str) -> bool:
        """Return whether gravity is on."""
        return bool(self.acceleration_m_s2)

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        yield from self.directed("direction")


class Camera(Section):
    """The line whose rotation from rest is the chord's angle, atan(−u_x/(L + u_z))."""

    role: ClassVar = Role.INSTRUMENT
    felt_by: ClassVar = ("finger",)
    later: ClassVar = {"markers": 0, "distance_mm": None, "centre_mm": None, "scale_mm": None}

    chord: Literal["centres", "back edges", "points"] = Field(
        "centres",
        description="from the clamped face's centre to the tip's, between the edges that the back "
        "(lowest x) has at clamp and tip, or between two points",
    )
    from_mm: Vector | None = Field(None, description="points: where the line begins, as meshed")
    to_mm: Vector | None = Field(None, description="points: where it ends, as meshed")
    markers: (
        Annotated[int, Ge(0), Le(100)]
        | Annotated[tuple[Place, ...], PURE, Field(strict=False, min_length=1, max_length=100)]
    ) = Field(
        0,
        description="number of markers along the middle of the back, at equal distances, the last "
        "one at the tip; or x and z (mm) of each at rest on the finger's side, as [[1.5, 20], …]; "
        "each has columns marker_1_x_mm, marker_1_z_mm, …",
    )
    distance_mm: float | None = Field(
        None, gt=0, le=1e6, description="of the camera from the plane of bending; default: far"
    )
    centre_mm: Place | None = Field(
        None, description="x and z from the clamp in the picture's middle; default: the clamp"
    )
    scale_mm: Annotated[tuple[Place, Place], Field(strict=False)] | None = Field(
        None, description="ends (x and z) of the length in the picture that told its scale"
    )

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        for key in ("from_mm", "to_mm"):
            value = getattr(self, key)
            if self.chord == "points" and value is None:
                yield Refusal(key, 'allowed with chord = "points": three numbers')
            if self.chord != "points" and value is not None:
                yield Refusal(key, 'allowed: with chord = "points"')
        if self.from_mm is not None and self.from_mm == self.to_mm:
            yield Refusal("to_mm", "allowed: another point than from_mm", list(self.from_mm))
