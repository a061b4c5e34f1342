"""A made-up shape of food: an egg, which lies still on its side."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from dolfingrip.foods.kind import Portion, SampledKind
from dolfingrip.foods.skin import sampled
from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.meshes.closed_surface import ClosedSurface


class Egg(SampledKind):
    """A ball, drawn out along x."""

    portions: ClassVar = {"egg": Portion(56.0, 44.0, 44.0, 1030.0)}

    def made(self, size_mm: tuple[float, float, float]) -> tuple[SignedDistance, ClosedSurface]:
        import pyvista as pv

        ball = pv.Icosphere(radius=0.5, nsub=3)
        triangles = np.asarray(ball.regular_faces, dtype=np.int64)
        return sampled(ClosedSurface(np.asarray(ball.points) * size_mm, triangles), self.grid_mm)
