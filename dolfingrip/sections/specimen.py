"""Sections of the configuration for the specimen: the finger, its mesh and shape parameters."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.geometry.index import GEOMETRIES, NAMES
from dolfingrip.sections.section import FINGERS, PLUGGED, Entry, Ratio, Refusal, Role, Section

if TYPE_CHECKING:  # the names are known as it runs only
    from dolfingrip.sections.geometry.bellows import Bellows

    Kind = str
else:
    Bellows = GEOMETRIES["bellows"]
    Kind = Literal[NAMES]


class Finger(Bellows):
    """Bellows finger: a base layer at x = 0, clamped at z = 0, bellows towards +x."""

    kind: Kind = Field(
        "bellows",
        description="of geometry; another than bellows has a table of its own",
        json_schema_extra=PLUGGED,
    )

    def movable(self, key: str) -> bool:
        """Return whether the solid has this dimension: other kinds have tables of their own."""
        return isinstance(self, GEOMETRIES[self.kind]) and super().movable(key)


HEXAHEDRON_MM, TETRAHEDRON_MM = 7.0, 2.8
"""Default of ``mesh.size_mm`` for each shape of the cells."""

EDGE_WALLS = 1 / 8
"""Default of ``mesh.edge_size_mm`` for hexahedra, as a part of the wall."""


class Mesh(Section):
    """Resolution of the mesh, or a mesh file of one's own."""

    role: ClassVar = Role.NUMERICS
    felt_by: ClassVar = FINGERS
    later: ClassVar = {"both_sides": False}

    file: Path | None = Field(
        None,
        strict=False,
        description="a .msh or Abaqus .inp with the groups cavity, clamp, skin, tip, symmetry",
    )
    half: bool = Field(True, description="half finger, symmetric in y = 0; false: both halves")
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
        1,
        ge=1,
        le=16,
        description="each cell is divided so often along each axis; tetrahedra "
        "and cells of a file: 1, 2, 4, 8 or 16",
    )
    target_elements: int | None = Field(
        None, ge=100, le=5_000_000, description="scale both sizes to this number of tetrahedra"
    )

    def hexahedra_mm(self, geometry: Geometry) -> tuple[float, float]:
        """Sizes (mm) of the largest hexahedra and of hexahedra at concave edges."""
        size = HEXAHEDRON_MM if self.size_mm is None else self.size_mm
        if self.edge_size_mm is None:
            return size, min(size, EDGE_WALLS * geometry.thinnest_mm)
        return size, self.edge_size_mm

    def tetrahedra_mm(self) -> tuple[float, float]:
        """Sizes (mm) of the largest tetrahedra and of tetrahedra at concave edges."""
        size = TETRAHEDRON_MM if self.size_mm is None else self.size_mm
        return size, self.edge_size_mm or size

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        if self.edge_size_mm is not None and self.size_mm is not None:
            yield from self.up_to("edge_size_mm", "size_mm")


class ThicknessMorph(Section):
    """Thickness of the meshed finger's regions: x below d_mm (A, strain-limiting) and above (B)."""

    role: ClassVar = Role.BODY
    felt_by: ClassVar = FINGERS
    entry: ClassVar = Entry.SHAPE

    xi1: Ratio = Field(0.0, ge=-0.2, le=1, description="relative change of region A's thickness")
    xi2: Ratio = Field(0.0, ge=-0.5, le=1, description="relative change of region B's thickness")
    d_mm: float = Field(9.5, gt=0, description="plane between the regions, before the morph")


class Cog(Section):
    """The point from which the unpressurised finger's offset of the centre of gravity counts."""

    role: ClassVar = Role.PROCEDURE
    felt_by: ClassVar = FINGERS

    x_ref_mm: float = Field(4.68, description="the offset is the centroid's x less this")
