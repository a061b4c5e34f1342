"""Which way a part bends by itself, read from its walls."""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.adoption.surface import Faces
from dolfingrip.meshes.solid import Floats


def bearing_centre(surface: Faces, span: tuple[float, float], axes: Floats) -> Floats | None:
    """Where, across the part, the material lies that runs through it and takes the pressure's pull.

    A wall with slits or an opening does not run through there: a line along the part counts by the
    share of it that lies in the solid, to a high power.

    Args:
        surface: the part, closed.
        span: where the part is hollow along the last axis (mm).
        axes: (3, 3) right-handed unit vectors, of which the last one is along the part.

    Returns:
        (3,) the centre (mm) in the surface's coordinates, at the height of the origin; None if
        nothing runs through.
    """
    policy = surface.policy
    turned = surface.moved(axes, np.zeros(3))
    cut = policy.ends * (span[1] - span[0])
    span = span[0] + cut, span[1] - cut
    box = turned.points[turned.triangles].reshape(-1, 3)[:, :2]
    first, size = box.min(axis=0), np.ptp(box, axis=0)
    cell = size.max() / policy.lines
    count = np.ceil(size / cell).astype(int) + 1
    # a regular grid would count a wall too wide or too narrow
    shift = np.random.default_rng(0).random((*count, 2))
    places = first + (np.moveaxis(np.indices(tuple(count)), 0, -1) + shift) * cell
    share = np.clip(_lengths(turned, places, (first, cell), span) / (span[1] - span[0]), 0.0, 1.0)
    weight = share**policy.bearing
    if weight.sum() < policy.near * weight.size:
        return None
    return np.asarray(np.einsum("ij,ijk->k", weight, places) / weight.sum() @ axes[:2])


def _lengths(
    surface: Faces,
    places: Floats,
    grid: tuple[Floats, float],
    span: tuple[float, float],
) -> Floats:
    """Lengths in the solid of lines along z within a span, as a sum over the triangles they meet.

    Args:
        surface: with z along the lines.
        places: (n, m, 2) of the lines, one in each cell of a grid.
        grid: the grid's corner and the size of its cells.
        span: lowest and highest z.

    Returns:
        (n, m) lengths (mm).
    """
    corner, cell = grid
    points = surface.points[surface.triangles]
    a, b, c = (points[:, i, :2] for i in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    limit = np.array(places.shape[:2]) - 1
    low = np.clip(((points[:, :, :2].min(axis=1) - corner) / cell).astype(int) - 1, 0, limit)
    high = np.clip(((points[:, :, :2].max(axis=1) - corner) / cell).astype(int) + 1, 0, limit)
    wide = np.where((np.abs(twice) > 1e-12)[:, None], high - low + 1, 0)
    total = wide.prod(axis=1)
    of = np.repeat(np.arange(len(points)), total)
    within = np.arange(total.sum()) - np.repeat(np.cumsum(total) - total, total)
    i, j = (low[of] + np.stack(np.divmod(within, wide[of, 1]), axis=1)).T
    at = places[i, j]

    def opposite(start: Floats, end: Floats) -> Floats:
        one, other = end[of] - start[of], at - start[of]
        return np.asarray((one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) / twice[of])

    shares = np.stack([opposite(b, c), opposite(c, a), opposite(a, b)], axis=1)
    met = (shares >= 0).all(axis=1)
    z = np.einsum("ij,ij->i", shares[met], points[of[met], :, 2])
    signed = np.sign(twice[of[met]]) * np.clip(z, *span)
    cells = i[met] * places.shape[1] + j[met]
    found = np.bincount(cells, signed, places[..., 0].size)
    return np.asarray(found, dtype=float).reshape(places.shape[:2])
