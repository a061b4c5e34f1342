"""``robot.json``: a finger as a chain of links, and its errors against finite elements."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from pydantic import Field

from dolfingrip.files.result_file import Part, ResultFile

Law = tuple[float, float, float, float]
"""Coefficients a, b, c, d of a p + b p w + c w + d p²."""


class JointCoordinate(Part):
    """A coordinate w of a joint, and the force or torque at it by pressure and coordinate."""

    name: str
    kind: Literal["slide", "hinge"] = Field(description="w is in mm, or in rad")
    axis: tuple[float, float, float] = Field(description="in the axes of the finger at rest")
    law: Law = Field(description="a, b, c, d of a p + b p w + c w + d p²: kPa; N, or N mm")
    damping_s: float = Field(description="damping by the largest stiffness")


class Joint(Part):
    """A joint: its place, and its coordinates from clamp to tip."""

    place_mm: tuple[float, float, float]
    coordinates: tuple[JointCoordinate, ...]


class Link(Part):
    """A rigid link at rest, in the finger's axes: the clamp is z = 0, the back x = 0."""

    mass_kg: float
    centre_mm: tuple[float, float, float]
    inertia_kg_mm2: tuple[float, float, float, float, float, float] = Field(
        description="xx, yy, zz, xy, xz, yz about the centre"
    )
    section_mm: tuple[tuple[float, float], ...] = Field(
        description="convex outline x, y of the prism that touches other bodies"
    )
    from_mm: float = Field(description="z where the prism begins")
    to_mm: float


class QuantityError(Part):
    """A quantity by finite elements and by the chain, at states that were not fitted."""

    quantity: str
    unit: str
    gap_mm: float | None = Field(description="of the plate; null: the finger is free")
    gravity_m_s2: tuple[float, float, float] = Field(
        (0.0, 0.0, 0.0), description="along x, y, z; an angle is since rest in it"
    )
    pressure_kPa: tuple[float, ...]
    finite_elements: tuple[float, ...]
    chain: tuple[float, ...]
    rms: float = Field(description="root mean square difference, in the unit")
    largest: float = Field(description="largest difference, in the unit")
    relative: float = Field(description="largest difference by the quantity's largest value; of a "
                            "stiffness, the largest ratio less 1")  # fmt: skip

    @property
    def title(self) -> str:
        """The quantity, and where the plate stood."""
        free = "hanging, with its weight" if any(self.gravity_m_s2) else "free"
        where = free if self.gap_mm is None else f"plate at {self.gap_mm:.3g} mm"
        return f"{self.quantity}, {where}"

    @property
    def error(self) -> float:
        """Error by its kind: an angle's largest one in degrees, a path's root mean square in mm,
        of others the relative one."""
        return {"deg": self.largest, "mm": self.rms}.get(self.unit, self.relative)


Motion = tuple[float, float, float]
"""Where a section or a link has moved in the plane of bending: x and z (mm) of its point at x = 0,
and how far it has turned (rad)."""


class FreeShape(Part):
    """The free finger at a pressure, by finite elements and by the chain."""

    pressure_kPa: float
    finite_elements: tuple[Motion, ...] = Field(description="of the sections at levels_mm")
    chain: tuple[Motion, ...] = Field(description="of each link, at its end towards the clamp")


class Accuracy(Part):
    """Errors that were asked for at states that were not fitted; the fewest joints within them."""

    angle_deg: float | None = Field(None, description="largest error of the tip's angle")
    path_mm: float | None = Field(None, description="root mean square error of the tip's path")
    force: float | None = Field(None, description="of a plate's force, by the largest one")
    stiffness: float | None = Field(None, description="of a stiffness of the tip, by itself")


class Validity(Part):
    """Pressures and loads that the chain was fitted to; beyond them the laws are not known."""

    pressure_kPa: tuple[float, float]
    force_N: float = Field(description="largest force on a plate")
    gaps_mm: tuple[float, ...] = Field(description="of the plates; null in pressure: free")
    ended: tuple[str, ...] = Field((), description="why runs ended early")


class Speed(Part):
    """How fast MuJoCo steps finger.xml, on one core of the machine that wrote it."""

    times_real_time: float = Field(description="simulated time by the processor's")
    step_s: float
    mujoco: str = Field(description="version")


class RobotFile(ResultFile):
    """Contents of ``robot.json``."""

    FILE: ClassVar[str] = "robot.json"
    MADE_BY: ClassVar[str] = "dolfingrip robot"

    schema_version: Literal[2] = 2
    config: dict[str, Any] = Field(description="resolved, of the runs")
    links: tuple[Link, ...] = Field(description="from the clamped one to the tip")
    joints: tuple[Joint, ...] = Field(description="one less than links")
    tip_mm: tuple[float, float, float] = Field(description="centre of the tip's face at rest")
    pressing_mm: tuple[tuple[float, float, float], ...] = Field(
        description="points of the back that may meet a plate, from clamp to tip"
    )
    facing_plate: int = Field(description="how many of these, from the tip, met the runs' plates")
    plate_N_per_mm: float = Field(description="stiffness of the chain's contact with a plate")
    line_s: float = Field(description="time constant of the pressure's supply")
    supply: dict[str, Any] | None = Field(
        None, description="of air, as configured: 95 % are reached after three constants; or none"
    )
    shape_error_mm: float = Field(
        description="rms distance of the free finger's sections from a chain of so many joints"
    )
    valid: Validity
    free_kPa: tuple[float, ...] = Field((), description="pressures of the free finger at rest")
    volume_mm3: tuple[float, ...] = Field((), description="of its cavity there; none of several")
    comparisons: tuple[QuantityError, ...]
    levels_mm: tuple[float, ...] = Field((), description="z of the shapes' sections at rest")
    shapes: tuple[FreeShape, ...] = Field((), description="from the lowest pressure on")
    accuracy: Accuracy | None = Field(
        None, description="what chose the number of joints; null: the free finger's shape"
    )
    simulated_s: float = Field(description="wall time of the runs of finite elements")
    speed: Speed | None = Field(None, description="null: MuJoCo was not there to measure it")
    versions: dict[str, str] = Field({}, description="of the software")

    @property
    def excess(self) -> float:
        """Largest error by the one that was asked for; 0, where none was."""
        wanted = self.accuracy or Accuracy()
        allowed = {"deg": wanted.angle_deg, "mm": wanted.path_mm, "N": wanted.force}
        allowed["N/mm"] = wanted.stiffness
        limits = [(comparison.error, allowed[comparison.unit]) for comparison in self.comparisons]
        return max((error / limit for error, limit in limits if limit is not None), default=0.0)
