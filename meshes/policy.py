"""The numbers that decide how meshes are graded and read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Grading:
    """How sizes grow from the concave edges of a finger, where stress concentrates.

    Attributes:
        coarse: element size, as part of the finger's depth, of the mesh that shows concave edges.
        flat_sine: sine of the angle below which two faces count as one smooth face.
        growth: of tetrahedra: growth of the element size (mm) with each mm of distance from a
            concave edge.
        ratio: of hexahedra: ratio of neighbouring cells' sizes away from a concave edge; the stress
            decays as r^-0.46.
        ratio_in_walls: the same of cells that grow into a thick wall, within which strain decays.
    """

    coarse: float = 0.25
    flat_sine: float = 1e-3
    growth: float = 0.5
    ratio: float = 7.0
    ratio_in_walls: float = 5.0


GRADING: Final = Grading()

ON_PLANE: Final = 1e-6
"""Distance from a plane, relative to a mesh's extent, up to which a point lies in it."""
