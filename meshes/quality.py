"""Checks of a mesh before it is used, and figures of its quality."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.meshes import groups, measures
from dolfingrip.meshes.cells import FACET_CORNERS
from dolfingrip.meshes.solid import (
    ON_PLANE,
    Ints,
    MeshError,
    SolidMesh,
    boundary,
    faces,
    labels,
    match,
    parts_of,
)


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


REFUSED: Final = 1e-4
"""Least scaled Jacobian below which elements are flat but for rounding."""

POOR: Final = 0.02
"""The same below which a solve near such an element may fail."""

THROUGH: Final = 0.5
"""Share of the cavities' walls that may be one element thick unsaid."""


OF_LINEAR = "linear ones (P1) are too stiff"
"""Words of the warning that matters to linear elements alone."""


def judge(mesh: SolidMesh, quality: Quality, what_to_do: str) -> tuple[str, ...]:
    """Judge a mesh by its figures.

    Args:
        mesh: checked.
        quality: its figures.
        what_to_do: words on how to make a better one.

    Returns:
        Warnings; none of a good mesh.

    Raises:
        MeshError: one line, if an element is all but flat.
    """
    least = quality.scaled_jacobian_min
    if least < REFUSED:
        raise MeshError(
            f"mesh: least scaled Jacobian {least:.2g}; allowed: from {REFUSED:g} on; {what_to_do}"
        )
    warnings = []
    if least < POOR:
        poor = int((measures.scaled_jacobians(mesh) < POOR).sum())
        warnings.append(
            f"{poor} of {quality.cells} elements have a scaled Jacobian below {POOR:g}, "
            f"{least:.2g} at least: steps near them may fail; {what_to_do}"
        )
    share = one_through(mesh)
    if share > THROUGH:
        warnings.append(
            f"one element through the wall at {share:.0%} of the cavity's walls: enough for "
            f"quadratic elements, but {OF_LINEAR} there; {what_to_do}"
        )
    return tuple(warnings)


def one_through(mesh: SolidMesh) -> float:
    """Share of the facets of cavities whose element reaches through to the outside.

    Args:
        mesh: checked.

    Returns:
        The share, between 0 and 1; 0 of a solid body.
    """
    inner = [mesh.facets[name] for name in groups.cavities(mesh.facets)]
    if not inner:
        return 0.0
    outside = np.unique(mesh.facets[groups.SKIN])
    rows = np.concatenate([match(facets, mesh.cells) for facets in inner])
    behind = mesh.cells[rows // len(mesh.shape.faces)]
    return float(np.isin(behind, outside).any(axis=1).mean())


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
    missing = [name for name in groups.BODY if not len(mesh.facets.get(name, ()))]
    if missing:
        raise MeshError(groups.missing_message(missing))
    least = measures.jacobians(mesh).min(axis=1)
    if least.min() <= 0:
        raise MeshError(
            f"mesh: Jacobian of {mesh.shape.name} {least.argmin()} is {least.min():.3g} mm³, "
            f"of {(least <= 0).sum()} in all not positive; allowed: above 0"
        )
    _check_groups(mesh)
    hollows = groups.cavities(mesh.facets)
    for name in hollows:
        _check_closed(mesh, name)
    _check_symmetry(mesh)
    closing = closing_mm3(mesh)
    cavities = {
        name: closing.get(name, 0.0) - measures.enclosed_volume(mesh.points, mesh.facets[name])
        for name in hollows
    }
    for name, volume in cavities.items():
        if volume <= 0:
            raise MeshError(
                f"group {name}: its facets enclose no hollow; allowed: the inner surface"
            )
    scaled = measures.scaled_jacobians(mesh)
    return Quality(
        shape=mesh.shape.plural,
        order=mesh.order,
        points=len(mesh.points),
        cells=len(mesh.cells),
        volume_mm3=sum(measures.enclosed_volume(mesh.points, f) for f in mesh.facets.values()),
        cavity_mm3=sum(cavities.values()),
        scaled_jacobian_min=float(scaled.min()),
        scaled_jacobian_median=float(np.median(scaled)),
        dihedral_min_deg=float(np.degrees(measures.dihedral_angles(mesh).min())),
        edge_min_mm=float(measures.edge_lengths(mesh).min()),
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
                f"allowed: exactly one of {', '.join(groups.SURFACE_TAGS)}, {groups.CAVITY}_2, …"
            )
    inward = len(grouped) - _common_rows(_canonical(grouped), _canonical(outer))
    if inward:
        raise MeshError(
            f"mesh: {inward} facets seen from inside; allowed: corners seen from outside"
        )


def _check_closed(mesh: SolidMesh, name: str) -> None:
    """Check that each edge of a cavity has two facets, or is at the clamp or in the symmetry plane.

    The integrand x · n of the volume is 0 on the symmetry plane. At the clamp, where a tube enters,
    the rim of an opening does not move: the part of the volume that no facet encloses is constant.
    """
    rim = _edges_of(mesh, name)[_open_edges(mesh, name)]
    open_edges = len(rim) - _common_rows(rim, _edges_of(mesh, groups.CLAMP)[:, ::-1])
    if open_edges:
        raise MeshError(
            f"group {name}: not closed, {open_edges} edges with one facet; "
            "allowed: two, or one on the symmetry plane or the clamp"
        )


def closing_mm3(mesh: SolidMesh) -> dict[str, float]:
    """Volume between the openings of a cavity and the origin, of the meshed part.

    With this constant, the volume that a cavity's facets enclose with the origin is the cavity's.

    Args:
        mesh: checked (mm).

    Returns:
        The volume by cavity, of those with an opening at the clamp.
    """
    by_cavity = {}
    corners = mesh.shape.facet_corners
    for name in groups.cavities(mesh.facets):
        open_edge = _open_edges(mesh, name)
        if not open_edge.any():
            continue
        facets = mesh.facets[name]
        rim = _directed_edges(facets[:, :corners])[open_edge]
        a, b = mesh.points[rim[:, 0]], mesh.points[rim[:, 1]]
        middle = (a + b) / 2
        if mesh.order == 2:
            middle = mesh.points[facets[:, corners:].ravel()[open_edge]]
        nodes, local = np.unique(rim, return_inverse=True)
        local = local.reshape(-1, 2)
        part = parts_of(local, len(nodes))
        count = np.bincount(part)
        apex = np.stack([np.bincount(part, x) / count for x in mesh.points[nodes].T], axis=1)
        if groups.SYMMETRY in mesh.facets:
            apex[:, 1] = 0.0
        top = apex[part[local[:, 0]]]
        # fans from the rim's middle to edges, which may be parabolas; Simpson's rule is exact
        fans = (
            np.stack([a, -3 * a + 4 * middle - b, top], axis=1),
            np.stack([middle, 4 * (b - a), top], axis=1),
            np.stack([b, a - 4 * middle + 3 * b, top], axis=1),
        )
        by_cavity[name] = float(sum(np.linalg.det(fan).sum() for fan in fans) / 36)
    return by_cavity


def _open_edges(mesh: SolidMesh, name: str) -> np.ndarray:
    """Mask (k,) of directed edges of a cavity with one facet that are not in the symmetry plane."""
    edges = _edges_of(mesh, name)
    others = np.concatenate([edges, _edges_of(mesh, groups.SYMMETRY)])[:, ::-1]
    return ~_among(edges, others)


def _edges_of(mesh: SolidMesh, name: str) -> Ints:
    """Directed edges of a group's facets, (k, 2)."""
    corners = mesh.shape.facet_corners
    facets = mesh.facets.get(name, np.empty((0, corners), dtype=np.int64))
    return _directed_edges(facets[:, :corners])


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
    return int(_among(rows, others).sum())


def _among(rows: Ints, others: Ints) -> np.ndarray:
    """Mask, (k,): whether each of ``rows`` is among ``others``."""
    both = np.concatenate([rows, others])
    _, label = np.unique(both, axis=0, return_inverse=True)
    return np.isin(label[: len(rows)], label[len(rows) :])


def _directed_edges(corners: Ints) -> Ints:
    return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
