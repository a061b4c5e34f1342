"""A potato: an ellipsoid with smooth bumps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from pydantic import Field

from dolfingrip.foods.kind import Portion, SampledKind
from dolfingrip.foods.skin import sampled
from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.meshes.solid import Floats
from dolfingrip.sections.section import outside


@dataclass(frozen=True, slots=True)
class PotatoShape:
    """How a potato is made.

    Attributes:
        bumps: number of bumps and dents.
        sharpness: k of a bump exp(k (cos − 1)), which falls to a third at an angle of about 33°.
        divisions: how often an icosahedron's edges are halved; this makes 2,562 points.
    """

    bumps: int = 12
    sharpness: float = 6.0
    divisions: int = 4


SHAPE: Final = PotatoShape()


class Potato(SampledKind):
    """A potato.

    USDA's FoodData Central (SR Legacy) lists a small one of 170 g and a large one of 369 g, 3 to
    4 1/4 in. Potatoes have a specific gravity of 1.06 to 1.10.
    """

    portions: ClassVar = {
        "potato-small": Portion(62.0, 80.0, 60.0, 1080.0),
        "potato-large": Portion(80.0, 106.0, 77.0, 1080.0),
    }

    bump_mm: float = Field(2.0, ge=0, le=20, description="potato: highest bump, deepest dent")
    seed: int = Field(1, ge=0, description="potato: of its bumps")

    def check(self, size_mm: tuple[float, float, float]) -> None:
        limit = min(size_mm) / 8
        if self.bump_mm > limit:
            raise outside("bump_mm", self.bump_mm, f"allowed: at least 0 and up to {limit:g} mm")

    def made(self, size_mm: tuple[float, float, float]) -> tuple[SignedDistance, ClosedSurface]:
        return sampled(potato(size_mm, self.bump_mm, self.seed), self.grid_mm)


def potato(size_mm: tuple[float, float, float], bump_mm: float, seed: int) -> ClosedSurface:
    """An ellipsoid with smooth bumps, which are random numbers of a seed.

    Its radius along n is that of the ellipsoid and Σ ±w_j exp(k (n · d_j − 1)), scaled so that
    the largest is ``bump_mm``.

    Args:
        size_mm: outer width, length and height of the ellipsoid.
        bump_mm: highest bump or deepest dent.
        seed: seed of the bumps' directions d_j and heights w_j.
    """
    import pyvista as pv

    ball = pv.Icosphere(radius=1.0, nsub=SHAPE.divisions)
    way = np.asarray(ball.points, dtype=float)
    way /= np.linalg.norm(way, axis=1)[:, None]
    half = np.array(size_mm) / 2
    radius = 1 / np.linalg.norm(way / half, axis=1)
    bumps = _bumps(way, seed)
    radius = radius + bump_mm * bumps / np.abs(bumps).max()
    triangles = np.asarray(ball.regular_faces, dtype=np.int64)
    surface = ClosedSurface(radius[:, None] * way, triangles)
    return surface.moved(-surface.centre_mm)


def _bumps(way: Floats, seed: int) -> Floats:
    """Heights along (n, 3) unit vectors, (n,)."""
    rng = np.random.default_rng(seed)
    places = rng.normal(size=(SHAPE.bumps, 3))
    places /= np.linalg.norm(places, axis=1)[:, None]
    heights = rng.uniform(-1, 1, SHAPE.bumps)
    return np.asarray(np.exp(SHAPE.sharpness * (way @ places.T - 1)) @ heights)
