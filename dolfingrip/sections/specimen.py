"""Sections of the configuration for the specimen: the finger, its mesh and shape parameters."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal, Protocol

from pydantic import Field, model_validator

from dolfingrip.sections.section import Section, check_up_to, outside


class Geometry(Protocol):
    """What the tables of all kinds of geometry tell."""

    @property
    def length_mm(self) -> float:
        """Clamp to tip, along z."""
        ...

    @property
    def thinnest_mm(self) -> float:
        """Thickness that sizes at concave edges are taken from."""
        ...


class Finger(Section):
    """Bellows finger: a base layer at x = 0, clamped at z = 0, bellows towards +x."""

    regions: ClassVar = ()

    length_mm: float = Field(90.0, gt=0, le=1000, description="clamp to tip, along z")
    width_mm: float = Field(20.0, gt=0, le=500, description="along y")
    depth_mm: float = Field(16.0, gt=0, le=500, description="back of base layer to bellows' crown")
    base_layer_mm: float = Field(3.5, gt=0, description="strain-limiting layer")
    wall_mm: float = Field(1.6, gt=0, description="walls of bellows and channel")
    bellows: int = Field(8, ge=1, le=60, description="number of bellows")
    gap_mm: float = Field(2.0, gt=0, description="clear distance between neighbouring bellows")
    channel_mm: float = Field(2.5, gt=0, description="height of the air channel")
    channel_width_mm: float | None = Field(
        None, gt=0, description="width of the air channel; default: as wide as the chambers"
    )
    base_block_mm: float = Field(12.0, gt=0, description="solid block at the clamp")
    tip_mm: float = Field(6.0, gt=0, description="solid tip")
    kind: Literal["bellows", "cast", "pneunet"] = Field(
        "bellows", description="of geometry; another than bellows has a table of its own"
    )

    @property
    def pitch_mm(self) -> float:
        """Distance from one bellows to the next."""
        return (self.length_mm - self.base_block_mm - self.tip_mm) / self.bellows

    @property
    def bellows_mm(self) -> float:
        """Outer length of one bellows along z."""
        return self.pitch_mm - self.gap_mm

    @property
    def chamber_width_mm(self) -> float:
        """Inner width of a bellows along y."""
        return self.width_mm - 2 * self.wall_mm

    @property
    def channel_width(self) -> float:
        """Width of the air channel (mm), the chambers' where none is given."""
        return self.chamber_width_mm if self.channel_width_mm is None else self.channel_width_mm

    @property
    def thinnest_mm(self) -> float:
        """Thickness that sizes at concave edges are taken from."""
        return self.wall_mm

    def count(self) -> tuple[str, int]:
        """Key and value of the number that no mesh can be moved to another of."""
        return "finger.bellows", self.bellows

    @model_validator(mode="after")
    def _possible(self) -> Finger:
        if self.tip_mm >= self.length_mm:
            raise outside(
                "tip_mm",
                self.tip_mm,
                f"allowed: above 0 and below length_mm = {self.length_mm:g} mm",
            )
        if self.pitch_mm <= 0:
            limit = self.length_mm - self.tip_mm
            raise outside(
                "base_block_mm",
                self.base_block_mm,
                f"leaves no room for bellows; allowed: above 0 and below {limit:g} mm",
            )
        if self.bellows_mm <= 0:
            raise outside(
                "gap_mm",
                self.gap_mm,
                f"leaves no bellows; allowed: above 0 and below the pitch, {self.pitch_mm:g} mm",
            )
        half = min(self.bellows_mm, self.width_mm, self.depth_mm) / 2
        if self.wall_mm >= half:
            raise outside(
                "wall_mm",
                self.wall_mm,
                f"thicker than half a bellows; allowed: above 0 and below {half:g} mm",
            )
        room = self.depth_mm - self.base_layer_mm - 2 * self.wall_mm
        if room <= 0:
            limit = self.depth_mm - 2 * self.wall_mm
            raise outside(
                "base_layer_mm",
                self.base_layer_mm,
                "leaves no room for a bellows above the channel; "
                f"allowed: above 0 and below {limit:g} mm",
            )
        highest = self.depth_mm - self.base_layer_mm - self.wall_mm
        if self.channel_mm >= highest:
            raise outside(
                "channel_mm",
                self.channel_mm,
                f"cavity not closed; allowed: above 0 and below {highest:g} mm",
            )
        if self.channel_width > self.chamber_width_mm:
            raise outside(
                "channel_width_mm",
                self.channel_width,
                f"cavity not closed; allowed: above 0 and up to {self.chamber_width_mm:g} mm",
            )
        return self


HEXAHEDRON_MM, TETRAHEDRON_MM = 7.0, 2.8
"""Largest element where ``mesh.size_mm`` is not given, by the shape of the cells."""

EDGE_WALLS = 1 / 8
"""Hexahedra at concave edges in walls, where ``mesh.edge_size_mm`` is not given."""


class Mesh(Section):
    """Resolution of the mesh, or a mesh file of one's own."""

    file: Path | None = Field(
        None,
        strict=False,
        description="a .msh or Abaqus .inp with the groups cavity, clamp, skin, tip, symmetry",
    )
    half: bool = Field(True, description="half finger with the symmetry plane y = 0")
    order: Literal[1, 2] | None = Field(
        None, description="order of the elements written to files; default: the solver's"
    )
    size_mm: float | None = Field(
        None,
        gt=0,
        le=100,
        description=f"largest element; default: {HEXAHEDRON_MM:g} for hexahedra, "
        f"{TETRAHEDRON_MM:g} for tetrahedra",
    )
    edge_size_mm: float | None = Field(
        None,
        gt=0,
        le=100,
        description="element size at concave edges; default: an eighth of the wall for "
        "hexahedra, size_mm for tetrahedra",
    )
    both_sides: bool = Field(
        False,
        description="hexahedra alone: graded on the solid side of concave edges, too, as walls "
        "much thicker than the chambers need",
    )
    refine: int = Field(
        1, ge=1, le=16, description="hexahedra alone: each is divided so often along each axis"
    )
    target_elements: int | None = Field(
        None, ge=100, le=5_000_000, description="scale both sizes to this number of tetrahedra"
    )

    def hexahedra_mm(self, geometry: Geometry) -> tuple[float, float]:
        """Largest hexahedron and that at concave edges (mm)."""
        size = HEXAHEDRON_MM if self.size_mm is None else self.size_mm
        if self.edge_size_mm is None:
            return size, min(size, EDGE_WALLS * geometry.thinnest_mm)
        return size, self.edge_size_mm

    def tetrahedra_mm(self) -> tuple[float, float]:
        """Largest tetrahedron and that at concave edges (mm)."""
        size = TETRAHEDRON_MM if self.size_mm is None else self.size_mm
        return size, self.edge_size_mm or size

    @model_validator(mode="after")
    def _sizes(self) -> Mesh:
        if self.edge_size_mm is not None and self.size_mm is not None:
            check_up_to(self, "edge_size_mm", "size_mm", "mm")
        return self


class Morph(Section):
    """Thickness of the meshed finger's regions: x below d_mm (A, strain-limiting) and above (B)."""

    xi1: float = Field(0.0, ge=-0.2, le=1, description="relative change of region A's thickness")
    xi2: float = Field(0.0, ge=-0.5, le=1, description="relative change of region B's thickness")
    d_mm: float = Field(9.5, gt=0, description="plane between the regions, before the morph")


class Cog(Section):
    """Where the centre of gravity's offset of the unpressurised finger is measured from."""

    x_ref_mm: float = Field(4.68, description="the offset is the centroid's x less this")
