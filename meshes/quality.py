"""Checks of a mesh before it is used, and figures of its quality."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dolfingrip.meshes import groups
from dolfingrip.meshes.cells import FACET_CORNERS
from dolfingrip.meshes.measures import (
    dihedral_angles,
    edge_lengths,
    enclosed_volume,
    jacobians,
    scaled_jacobians,
)
from dolfingrip.meshes.solid import ON_PLANE, Ints, MeshError, SolidMesh, boundary, faces, labels


@dataclass(frozen=True, slots=True)
class Quality:
    """The figures of a checked mesh.

    Attributes:
        shape, order, points, cells: name of the elements (``tetrahedra``, ``hexahedra``), their
            order, and the numbers.
        volume_mm3, cavity_mm3: volume of the solid and of the cavity it encloses (of the half, for
            a half finger).
        scaled_jacobian_min, scaled_jacobian_median: with straight edges; 1 for the regular
            tetrahedron and for boxes, 0 for flat elements.
        dihedral_min_deg: smallest angle between two faces of an element.
        edge_min_mm: shortest edge between corners.
    """

    shape: str
    order: int
    points: int
    cells: int
    volume_mm3: float
    cavity_mm3: float
    scaled_jacobian_min: float
    scaled_jacobian_median: float
    dihedral_min_deg: float
    edge_min_mm: float

    def summary(self) -> str:
        """One line for the log."""
        return (
            f"{self.cells} {self.shape} of order {self.order}, {self.points} points, "
            f"solid {self.volume_mm3:.1f} mm³, cavity {self.cavity_mm3:.1f} mm³, "
            f"scaled Jacobian min {self.scaled_jacobian_min:.2g} "
            f"median {self.scaled_jacobian_median:.2f}, "
            f"dihedral angle min {self.dihedral_min_deg:.2g}°, "
            f"edge min {self.edge_min_mm:.2g} mm"
        )


def check(mesh: SolidMesh) -> Quality:
    """Check a mesh and measure its quality.

    Args:
        mesh: mesh of a finger (mm).

    Returns:
        Figures of the mesh.

    Raises:
        MeshError: where a needed group is empty, a Jacobian is not positive, the facets are not the
            solid's boundary facing outward with exactly one group each, the cavity is not closed,
            or the symmetry group does not lie in y = 0.
    """
    missing = [name for name in groups.NEEDED if not len(mesh.facets.get(name, ()))]
    if missing:
        raise MeshError(groups.missing_message(missing))
    least = jacobians(mesh).min(axis=1)
    if least.min() <= 0:
        raise MeshError(
            f"mesh: Jacobian of {mesh.shape.name} {least.argmin()} is {least.min():.3g} mm³, "
            f"of {(least <= 0).sum()} in all not positive; allowed: above 0"
        )
    _check_groups(mesh)
    for name in groups.CAVITIES:
        if name in mesh.facets:
            _check_closed(mesh, name)
    _check_symmetry(mesh)
    cavities = {
        name: -enclosed_volume(mesh.points, mesh.facets[name])
        for name in groups.CAVITIES
        if name in mesh.facets
    }
    for name, volume in cavities.items():
        if volume <= 0:
            raise MeshError(
                f"group {name}: its facets enclose no hollow; allowed: the inner surface"
            )
    scaled = scaled_jacobians(mesh)
    return Quality(
        shape=mesh.shape.plural,
        order=mesh.order,
        points=len(mesh.points),
        cells=len(mesh.cells),
        volume_mm3=sum(enclosed_volume(mesh.points, f) for f in mesh.facets.values()),
        cavity_mm3=sum(cavities.values()),
        scaled_jacobian_min=float(scaled.min()),
        scaled_jacobian_median=float(np.median(scaled)),
        dihedral_min_deg=float(np.degrees(dihedral_angles(mesh).min())),
        edge_min_mm=float(edge_lengths(mesh).min()),
    )


def _check_groups(mesh: SolidMesh) -> None:
    """Check that each boundary facet, seen from outside, is in one group, and no other facet is."""
    every = faces(mesh.cells)
    outer = every[boundary(mesh.cells)]
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


def _check_closed(mesh: SolidMesh, name: str) -> None:
    """Check that each edge of a cavity borders on two facets or lies on a plane that closes it.

    Two planes close it: the symmetry plane, and the clamped plane z = 0 where a tube enters. The
    opening there does not move, and the volume's integrand x · n is 0.
    """
    corners = mesh.shape.facet_corners
    cavity, plane, clamp = (
        mesh.facets.get(group, np.empty((0, corners), dtype=np.int64))[:, :corners]
        for group in (name, groups.SYMMETRY, groups.CLAMP)
    )
    extent = float(np.ptp(mesh.points, axis=0).max())
    clamp = clamp[(np.abs(mesh.points[clamp, 2]) <= ON_PLANE * extent).all(axis=1)]
    edges = _directed_edges(cavity)
    others = np.concatenate([_directed_edges(plane), _directed_edges(clamp)])
    back = np.concatenate([edges, others])[:, ::-1]
    open_edges = len(edges) - _common_rows(edges, back)
    if open_edges:
        raise MeshError(
            f"group {name}: not closed, {open_edges} edges with one facet; "
            "allowed: two, or one on the symmetry plane or the clamped plane z = 0"
        )


def _check_symmetry(mesh: SolidMesh) -> None:
    plane = mesh.facets.get(groups.SYMMETRY)
    if plane is None or not len(plane):
        return
    off = float(np.abs(mesh.points[plane, 1]).max())
    if off > ON_PLANE * float(np.ptp(mesh.points, axis=0).max()):
        raise MeshError(f"group symmetry: {off:.3g} mm off its plane; allowed: y = 0")


def _canonical(facets: Ints) -> Ints:
    """Facets whose corners are rotated so that the lowest is first; they keep their side."""
    corners = FACET_CORNERS[facets.shape[1]]
    first = np.argmin(facets[:, :corners], axis=1)[:, None]
    return np.take_along_axis(facets, (first + np.arange(corners)) % corners, axis=1)


def _common_rows(rows: Ints, others: Ints) -> int:
    """Number of ``rows`` that are among ``others``."""
    both = np.concatenate([rows, others])
    _, label = np.unique(both, axis=0, return_inverse=True)
    return int(np.isin(label[: len(rows)], label[len(rows) :]).sum())


def _directed_edges(corners: Ints) -> Ints:
    return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
