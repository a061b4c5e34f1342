"""Potatoes as closed surfaces; see :mod:`dolfingrip.sections.food` for sizes and sources.

Sausages and cubes have a signed distance in closed form instead, and
:func:`~dolfingrip.meshes.closed_surface.level_set` makes their surfaces. The width of all food is
along x, its length along y and its height along z.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.meshes.solid import Floats

BUMPS: Final = 12
"""Number of bumps and dents of a potato."""

SHARPNESS: Final = 6.0
"""k of a bump exp(k (cos − 1)), which falls to a third at an angle of about 33°."""

DIVISIONS: Final = 4
"""How often an icosahedron's edges are halved; this makes 2,562 points."""


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

    ball = pv.Icosphere(radius=1.0, nsub=DIVISIONS)
    way = np.asarray(ball.points, dtype=float)
    way /= np.linalg.norm(way, axis=1)[:, None]
    half = np.array(size_mm) / 2
    radius = 1 / np.linalg.norm(way / half, axis=1)
    bumps = _bumps(way, seed)
    radius = radius + bump_mm * bumps / np.abs(bumps).max()
    triangles = np.asarray(ball.regular_faces, dtype=np.int64)
    found = ClosedSurface(radius[:, None] * way, triangles)
    return found.moved(-found.centre_mm)


def _bumps(way: Floats, seed: int) -> Floats:
    """(n,) heights along (n, 3) unit vectors."""
    rng = np.random.default_rng(seed)
    places = rng.normal(size=(BUMPS, 3))
    places /= np.linalg.norm(places, axis=1)[:, None]
    heights = rng.uniform(-1, 1, BUMPS)
    return np.asarray(np.exp(SHARPNESS * (way @ places.T - 1)) @ heights)
