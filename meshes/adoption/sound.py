"""Whether a surface encloses a solid, how thin its walls and gaps are, and which way it bends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from vtkmodules.vtkCommonCore import mutable

from dolfingrip.meshes.adoption.surface import Faces, edge_counts
from dolfingrip.meshes.closed_surface import locator
from dolfingrip.meshes.solid import Floats, Ints, MeshError, parts_of


@dataclass(frozen=True, slots=True)
class SizePolicy:
    """How the size of elements follows from a part's walls.

    Attributes:
        samples: places at which walls and gaps are measured.
        opposite_deg: angle within which two sides of a wall face away from one another.
        thin: share of the surface that may belong to thinner walls than the thinnest one counted.
        by_wall: size of elements by the thinnest wall.
        most_by_wall: largest size by the thinnest wall: one quadratic element bears the bending of
            a wall if it is not much flatter than that.
        across: least number of elements across the part.
        curved: elements around a full turn of a curved face.
        most: largest number of elements that is made unasked.
        filled: volume of a tetrahedron by the cube of its size.
        cap_walls: thickness of a cap by the thinnest wall.
        into_wall: how far a cap reaches into the wall around it, by that wall's thickness.
        sliver: quality of tetrahedra (inscribed by circumscribed radius, 1 at best) below which
            another size is tried.
        poor: least scaled Jacobian below which half a part of triangles is not taken.
        tried: sizes that are tried, by the one that the walls ask for.
    """

    samples: int = 3000
    opposite_deg: float = 45.0
    thin: float = 0.01
    by_wall: float = 1.5
    most_by_wall: float = 2.5
    across: float = 4.0
    curved: float = 12.0
    most: int = 300_000
    filled: float = 0.118
    cap_walls: float = 1.5
    into_wall: float = 0.4
    sliver: float = 0.05
    poor: float = 0.01
    tried: tuple[float, ...] = (1.0, 0.93, 0.86, 0.8)


def place(point: Floats) -> str:
    """A point in words.

    Args:
        point: (3,) coordinates (mm).
    """
    return "(" + ", ".join(f"{round(float(value), 2) + 0.0:g}" for value in point) + ") mm"


def check_watertight(points: Floats, triangles: Ints) -> None:
    """Refuse a surface with holes, or with edges of more than two triangles.

    Args:
        points: (n, 3) points (mm).
        triangles: (m, 3) points of each triangle.

    Raises:
        MeshError: one line with their number and the place of the largest.
    """
    edges, count = edge_counts(triangles)
    free = edges[count == 1]
    if len(free):
        nodes, local = np.unique(free, return_inverse=True)
        local = local.reshape(-1, 2)
        part = parts_of(local, len(nodes))
        length = np.linalg.norm(points[free[:, 0]] - points[free[:, 1]], axis=1)
        around = np.bincount(part[local[:, 0]], length)
        largest = part[local[:, 0]] == around.argmax()
        at = points[free[largest]].mean(axis=(0, 1))
        holes = "a hole" if len(around) == 1 else f"{len(around)} holes, the largest"
        raise MeshError(
            f"not watertight: {holes} with an edge of {around.max():.3g} mm around {place(at)}; "
            "allowed: a closed surface"
        )
    many = edges[count > 2]
    if len(many):
        at = points[many].mean(axis=1)[0]
        raise MeshError(
            f"not watertight: {len(many)} edges have more than two triangles, one at {place(at)}; "
            "allowed: two at each edge"
        )


def check_crossings(points: Floats, triangles: Ints) -> None:
    """Refuse a surface that intersects itself.

    Raises:
        MeshError: one line with the place of a crossing.
    """
    if not _crosses(points, triangles):
        return
    crossing = triangles
    while len(crossing) > 12:
        corners = points[crossing]
        low, high = corners.min(axis=1), corners.max(axis=1)
        axis = int((high.max(axis=0) - low.min(axis=0)).argmax())
        middle = float(np.median(corners.mean(axis=1)[:, axis]))
        halves = crossing[low[:, axis] <= middle], crossing[high[:, axis] >= middle]
        smaller = [half for half in halves if len(half) < len(crossing) and _crosses(points, half)]
        if not smaller:
            break
        crossing = min(smaller, key=len)
    at = points[crossing].mean(axis=(0, 1))
    raise MeshError(
        f"intersects itself near {place(at)}; allowed: a surface without crossings "
        "(unite the bodies where it was drawn)"
    )


def _crosses(points: Floats, triangles: Ints) -> bool:
    import ipctk

    used, local = np.unique(triangles, return_inverse=True)
    faces = np.asfortranarray(local.reshape(-1, 3).astype(np.int32))
    at = np.asfortranarray(points[used])
    mesh = ipctk.CollisionMesh(at, ipctk.edges(faces), faces)
    return bool(ipctk.has_intersections(mesh, at))


@dataclass(frozen=True, slots=True)
class Thinnest:
    """The thinnest wall or narrowest gap that counts.

    Attributes:
        mm: its thickness; infinite where there is none.
        at_mm: (3,) where it is.
    """

    mm: float
    at_mm: Floats


def thinnest(
    surface: Faces, policy: SizePolicy, *, outside: bool = False, among: np.ndarray | None = None
) -> Thinnest:
    """The thinnest wall, by lines from places on the surface into the solid.

    Sharp edges do not count: both sides must face away from one another. Nor do the thinnest
    places with a share of ``policy.thin`` of the surface.

    Args:
        surface: closed.
        policy: where and how walls are measured.
        outside: the narrowest gap instead, by lines out of the solid.
        among: (m,) triangles that lines start at; all where None.
    """
    tree = locator(surface.points, surface.triangles)
    rng = np.random.default_rng(0)
    weights = surface.areas if among is None else np.where(among, surface.areas, 0.0)
    chosen = rng.choice(len(weights), policy.samples, p=weights / weights.sum())
    share = rng.dirichlet(np.ones(3), policy.samples)
    start = np.einsum("ni,nij->nj", share, surface.points[surface.triangles[chosen]])
    way = surface.normals[chosen] * (1.0 if outside else -1.0)
    longest, small = 2 * surface.extent, 1e-6 * surface.extent
    t, sub, cell = mutable(0.0), mutable(0), mutable(0)
    hit, angle = np.zeros(3), np.zeros(3)
    length = np.full(policy.samples, np.inf)
    least = np.cos(np.radians(policy.opposite_deg))
    for i, (a, b) in enumerate(zip(start + small * way, start + longest * way, strict=True)):
        if not tree.IntersectWithLine(a, b, 0.0, t, hit, angle, sub, cell):
            continue
        if -surface.normals[int(cell)] @ surface.normals[chosen[i]] > least:
            length[i] = float(np.linalg.norm(hit - start[i]))
    order = np.argsort(length)
    if not np.isfinite(length[order[0]]):
        return Thinnest(float("inf"), surface.middles[0])
    row = order[int(policy.thin * np.isfinite(length).sum())]
    return Thinnest(float(length[row]), start[row])


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
    lengths = np.bincount(cells, signed, places[..., 0].size)
    return np.asarray(lengths, dtype=float).reshape(places.shape[:2])
