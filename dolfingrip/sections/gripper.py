"""Section of the configuration for the gripper: places of its fingers, and its motion."""

from __future__ import annotations

from typing import ClassVar, Final, Literal

from pydantic import Field

from dolfingrip.sections.section import Role, Section

GripPose = Literal["scoop", "pinch", "claw"]

ALPHA_DEG: Final[dict[str, float]] = {"scoop": -45.0, "pinch": 90.0, "claw": 0.0}
"""Rotation of fingers B and C for each pose if ``alpha_deg`` is not given. The paper has 0° for the
claw and 90° for the pinch. It has no number for the scoop, with both fingers close to the thumb."""

CLEARANCE_MM: Final[dict[str, float]] = {"scoop": 4.0, "pinch": 42.0, "claw": 4.0}
"""Distance of straight fingers from the food if none is given. The paper has no number. The
pinch's is such that its cube is first picked up at its 150 kPa with μ = 0.38 (coarse preset)."""

OTHER_CLEARANCE_MM: Final = 4.0
"""Distance of straight fingers from the food if ``alpha_deg`` is given."""


HIGHEST_KPA: Final = 300.0
"""Pressure above which no search tries a grasp, unless another one is told; the paper's highest."""


class Gripper(Section):
    """A thumb A and two fingers B, C around a centre O, as in the paper's Fig. 5(c)."""

    role: ClassVar = Role.SETUP
    felt_by: ClassVar = ("gripper",)
    later: ClassVar = {"approach_mm": 30.0, "lift_acceleration_m_s2": None, "lift_readings": 6}

    preset: Literal["coarse", "default"] = Field(
        "default", description="coarse: fingers of 11,000 dofs each, not graded to their edges"
    )
    pose: GripPose = Field("pinch", description="how fingers B and C are turned")
    alpha_deg: float | None = Field(
        None, ge=-80, le=90, description="of B and C about their centres; default: by pose"
    )
    L_mm: float | None = Field(
        None, gt=0, le=300, description="thumb A to centre O; default: next to the food"
    )
    W_mm: float = Field(
        12.0, ge=0, le=300, description="offset of B's and C's rotation centres from O"
    )
    R_mm: float | None = Field(
        None, ge=0, le=300, description="B, C to rotation centres; default: next to the food"
    )
    clearance_mm: float | None = Field(
        None,
        gt=0,
        le=100,
        description="finger to food where L_mm, R_mm are not given; default: by pose",
    )
    tip_height_mm: float = Field(
        4.0, gt=0, le=300, description="of the straight fingers' tips above the table"
    )
    pressurise_s: float = Field(2.0, gt=0, le=600, description="ramp to the pressure (paper: 2 s)")
    settle_s: float = Field(0.5, gt=0, le=600, description="wait before the lift, and after it")
    approach_mm: float = Field(
        30.0, gt=0, le=500, description="way of the table to the fingers that suction has opened"
    )
    lift_mm: float = Field(30.0, gt=0, le=500, description="way up")
    lift_mm_per_s: float = Field(
        30.0, gt=0, le=1000, description="speed of the lift, and of the approach"
    )
    lift_acceleration_m_s2: float | None = Field(
        None,
        gt=0,
        le=100,
        description="acceleration to that speed and from it, in the lift; default: at once, unfelt",
    )
    lift_readings: int = Field(
        6,
        ge=1,
        le=1000,
        description="readings while the table moves; with experiment.dynamic as many a second "
        "after the lift",
    )
    half: bool | None = Field(
        None,
        description="compute half a thumb and one finger, the rest as its mirror image; "
        "default: where fingers and food are symmetric",
    )
    step_s: float = Field(0.15, gt=0, le=10, description="longest step in time")
    barrier_mm: float = Field(0.4, gt=0, le=10, description="distance at which food is felt")
    stiffness_MPa: float = Field(0.05, gt=0, description="of that barrier")

    @property
    def alpha(self) -> float:
        """Rotation of B and C (deg)."""
        return ALPHA_DEG[self.pose] if self.alpha_deg is None else self.alpha_deg

    @property
    def clearance(self) -> float:
        """Distance of straight fingers from the food (mm) if L and R are not given."""
        if self.clearance_mm is not None:
            return self.clearance_mm
        return CLEARANCE_MM[self.pose] if self.alpha_deg is None else OTHER_CLEARANCE_MM
