"""What must hold before a mesh is computed on, and the figures that tell how good it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.meshes import groups
from dolfingrip.meshes.solid import (
    EDGES,
    Floats,
    Ints,
    MeshError,
    SolidMesh,
    boundary,
    faces,
    labels,
)

_OFF_PLANE: Final = 1e-6
"""Largest distance of the symmetry group from y = 0, relative to the mesh's extent."""

_LATTICE: Final = (
    np.array([[i, j, k] for i in range(4) for j in range(4 - i) for k in range(4 - i - j)]) / 3
)
"""Points at which Jacobians are checked; they determine that of a second-order element."""

_TRIANGLE_POINTS: Final = np.array(
    [[a, a] for a in (0.445948490915965, 0.091576213509771)]
    + [[1 - 2 * a, a] for a in (0.445948490915965, 0.091576213509771)]
    + [[a, 1 - 2 * a] for a in (0.445948490915965, 0.091576213509771)]
)
_TRIANGLE_WEIGHTS: Final = np.tile([0.223381589678011, 0.109951743655322], 3) / 2
"""Quadrature on the triangle, exact for degree 4 (Dunavant 1985)."""


@dataclass(frozen=True, slots=True)
class Quality:
    """Figures of a checked mesh.

    Attributes
    ----------
    order, points, tetrahedra
        Order of the elements and their numbers.
    volume_mm3, cavity_mm3
        Volume of the solid and of the cavity it encloses (of the half, for a half finger).
    scaled_jacobian_min, scaled_jacobian_median
        1 for the regular tetrahedron, 0 for a flat one; of the corners' tetrahedron.
    dihedral_min_deg
        Smallest angle between two faces of a tetrahedron.
    edge_min_mm
        Shortest edge between corners.
    """

    order: int
    points: int
    tetrahedra: int
    volume_mm3: float
    cavity_mm3: float
    scaled_jacobian_min: float
    scaled_jacobian_median: float
    dihedral_min_deg: float
    edge_min_mm: float

    def summary(self) -> str:
        """One line for the log."""
        return (
            f"{self.tetrahedra} tetrahedra of order {self.order}, {self.points} points, "
            f"solid {self.volume_mm3:.1f} mm³, cavity {self.cavity_mm3:.1f} mm³, "
            f"scaled Jacobian min {self.scaled_jacobian_min:.2g} "
            f"median {self.scaled_jacobian_median:.2f}, "
            f"dihedral angle min {self.dihedral_min_deg:.2g}°, "
            f"edge min {self.edge_min_mm:.2g} mm"
        )


def check(mesh: SolidMesh) -> Quality:
    """Check a mesh and measure its quality.

    Raises
    ------
    MeshError
        Where a needed group is empty, a Jacobian is not positive, the facets are not the
        solid's boundary facing outward with exactly one group each, the cavity is not
        closed, or the symmetry group does not lie in y = 0.
    """
    missing = [name for name in groups.NEEDED if not len(mesh.facets.get(name, ()))]
    if missing:
        raise MeshError(groups.missing_message(missing))
    least = jacobians(mesh).min(axis=1)
    if least.min() <= 0:
        raise MeshError(
            f"mesh: Jacobian of tetrahedron {least.argmin()} is {least.min():.3g} mm³, "
            f"of {(least <= 0).sum()} in all not positive; allowed: above 0"
        )
    _check_groups(mesh)
    _check_closed(mesh)
    _check_symmetry(mesh)
    cavity = -enclosed_volume(mesh.points, mesh.facets[groups.CAVITY])
    if cavity <= 0:
        raise MeshError("group cavity: its facets enclose no hollow; allowed: the inner surface")
    scaled = scaled_jacobians(mesh)
    return Quality(
        order=mesh.order,
        points=len(mesh.points),
        tetrahedra=len(mesh.tetrahedra),
        volume_mm3=sum(enclosed_volume(mesh.points, f) for f in mesh.facets.values()),
        cavity_mm3=cavity,
        scaled_jacobian_min=float(scaled.min()),
        scaled_jacobian_median=float(np.median(scaled)),
        dihedral_min_deg=float(np.degrees(dihedral_angles(mesh).min())),
        edge_min_mm=float(_edge_lengths(mesh).min()),
    )


def _check_groups(mesh: SolidMesh) -> None:
    """Every boundary facet, seen from outside, is in one group; no other facet is in any."""
    every = faces(mesh.tetrahedra)
    outer = every[boundary(mesh.tetrahedra)]
    grouped = np.concatenate(list(mesh.facets.values()))
    label = labels(np.concatenate([outer, grouped]))
    times = np.bincount(label[len(outer) :], minlength=label.max() + 1)
    on_boundary = np.bincount(label[: len(outer)], minlength=label.max() + 1) > 0
    for number, what in (
        ((on_boundary & (times == 0)).sum(), "in no group"),
        ((on_boundary & (times > 1)).sum(), "in more than one group"),
        ((~on_boundary).sum(), "in a group but inside the solid"),
    ):
        if number:
            raise MeshError(
                f"mesh: {number} facets {what}; "
                f"allowed: exactly one of {', '.join(groups.SURFACE_TAGS)}"
            )
    inward = len(grouped) - _common_rows(_canonical(grouped), _canonical(outer))
    if inward:
        raise MeshError(
            f"mesh: {inward} facets seen from inside; allowed: corners seen from outside"
        )


def _check_closed(mesh: SolidMesh) -> None:
    """Each edge of the cavity leads back in a neighbour, or lies on the symmetry plane."""
    cavity, plane = (
        mesh.facets.get(name, np.empty((0, 3), dtype=np.int64))[:, :3]
        for name in (groups.CAVITY, groups.SYMMETRY)
    )
    edges, others = _directed_edges(cavity), _directed_edges(plane)
    back = np.concatenate([edges, others])[:, ::-1]
    open_edges = len(edges) - _common_rows(edges, back)
    if open_edges:
        raise MeshError(
            f"group cavity: not closed, {open_edges} edges with one facet; "
            "allowed: two, or one on the symmetry plane"
        )


def _check_symmetry(mesh: SolidMesh) -> None:
    plane = mesh.facets.get(groups.SYMMETRY)
    if plane is None or not len(plane):
        return
    off = float(np.abs(mesh.points[plane, 1]).max())
    if off > _OFF_PLANE * float(np.ptp(mesh.points, axis=0).max()):
        raise MeshError(f"group symmetry: {off:.3g} mm off its plane; allowed: y = 0")


def _canonical(facets: Ints) -> Ints:
    """Corners rotated so that the lowest is first, which keeps the side they are seen from."""
    first = np.argmin(facets[:, :3], axis=1)[:, None]
    return np.take_along_axis(facets[:, :3], (first + np.arange(3)) % 3, axis=1)


def _common_rows(rows: Ints, others: Ints) -> int:
    """Number of ``rows`` that are among ``others``."""
    both = np.concatenate([rows, others])
    _, label = np.unique(both, axis=0, return_inverse=True)
    return int(np.isin(label[: len(rows)], label[len(rows) :]).sum())


def _directed_edges(triangles: Ints) -> Ints:
    return triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def jacobians(mesh: SolidMesh) -> Floats:
    """Determinant of each element's Jacobian (mm³), shape (m, 1) or (m, 20).

    That of a first-order element is constant, that of a second-order one a cubic, given at
    the 20 points that determine it.
    """
    corners = mesh.points[mesh.tetrahedra[:, :4]]
    if mesh.order == 1:
        return np.linalg.det(corners[:, 1:] - corners[:, :1])[:, None]
    nodes = mesh.points[mesh.tetrahedra]
    columns = [np.linalg.det(np.einsum("nk,mni->mki", g, nodes)) for g in _gradients(_LATTICE)]
    return np.stack(columns, axis=1)


def _gradients(at: Floats) -> Floats:
    """Gradients of the ten quadratic shape functions, shape (q, 10, 3), at points (q, 3)."""
    barycentric = np.column_stack([1 - at.sum(axis=1), at])
    d = np.vstack([-np.ones(3), np.eye(3)])
    corners = (4 * barycentric[:, :, None] - 1) * d
    i, j = EDGES.T
    middles = 4 * (barycentric[:, i, None] * d[j] + barycentric[:, j, None] * d[i])
    return np.concatenate([corners, middles], axis=1)


def enclosed_volume(points: Floats, facets: Ints) -> float:
    """Integral of x·n / 3 over the facets (mm³): the volume they enclose, where closed.

    A surface that ends on planes through the origin encloses its volume with them.

    Parameters
    ----------
    points
        Shape (n, 3), mm.
    facets
        Shape (k, 3) or (k, 6), as in :class:`SolidMesh`.
    """
    x = points[facets]
    if facets.shape[1] == 3:
        return float(np.einsum("ki,ki->", x[:, 0], np.cross(x[:, 1], x[:, 2]))) / 6
    total = 0.0
    for (r, s), weight in zip(_TRIANGLE_POINTS, _TRIANGLE_WEIGHTS, strict=True):
        t = 1 - r - s
        shape = [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t]
        along_r = [1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s]
        along_s = [1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)]
        at, dr, ds = (np.einsum("n,kni->ki", np.array(n), x) for n in (shape, along_r, along_s))
        total += weight * float(np.einsum("ki,ki->", at, np.cross(dr, ds))) / 3
    return total


def scaled_jacobians(mesh: SolidMesh) -> Floats:
    """Jacobian over the largest product of three edges that meet in a corner, times √2, (m,)."""
    corners = mesh.points[mesh.tetrahedra[:, :4]]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1])
    length = _edge_lengths(mesh)
    # edges 01 12 02 03 23 13 meet in the corners 0, 1, 2, 3 like this
    products = [length[:, e].prod(axis=1) for e in ([0, 2, 3], [0, 1, 5], [1, 2, 4], [3, 4, 5])]
    scaled: Floats = np.sqrt(2) * volume / np.max(products, axis=0)
    return scaled


def dihedral_angles(mesh: SolidMesh) -> Floats:
    """Angles between the faces of each tetrahedron, shape (m, 6), rad."""
    triangles = mesh.points[faces(mesh.tetrahedra[:, :4])].reshape(-1, 4, 3, 3)
    normals = np.cross(
        triangles[:, :, 1] - triangles[:, :, 0], triangles[:, :, 2] - triangles[:, :, 0]
    )
    normals /= np.linalg.norm(normals, axis=2)[:, :, None]
    i, j = EDGES.T
    cosines = -np.einsum("mei,mei->me", normals[:, i], normals[:, j])
    return np.arccos(np.clip(cosines, -1, 1))


def _edge_lengths(mesh: SolidMesh) -> Floats:
    ends = mesh.points[mesh.tetrahedra[:, EDGES]]
    lengths: Floats = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
    return lengths
