"""Whether a surface encloses a solid, and how thin the walls and gaps of that solid are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from vtkmodules.vtkCommonCore import mutable

from dolfingrip.meshes.adoption.policy import SizePolicy
from dolfingrip.meshes.adoption.surface import Faces, edge_counts, parts_of
from dolfingrip.meshes.closed_surface import locator
from dolfingrip.meshes.solid import Floats, Ints, MeshError


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
    found = triangles
    while len(found) > 12:
        corners = points[found]
        low, high = corners.min(axis=1), corners.max(axis=1)
        axis = int((high.max(axis=0) - low.min(axis=0)).argmax())
        middle = float(np.median(corners.mean(axis=1)[:, axis]))
        halves = found[low[:, axis] <= middle], found[high[:, axis] >= middle]
        smaller = [half for half in halves if len(half) < len(found) and _crosses(points, half)]
        if not smaller:
            break
        found = min(smaller, key=len)
    at = points[found].mean(axis=(0, 1))
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
