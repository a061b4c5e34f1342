"""Links of a finger: mass, inertia, outline, and the skin that is bound to them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial import ConvexHull

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.files.robot import Link
from dolfingrip.meshes import cells, groups
from dolfingrip.meshes.bisection import PARTS, corners_of_parts
from dolfingrip.meshes.closed_surface import MM3_PER_M3
from dolfingrip.meshes.measures import CELL_QUADRATURE
from dolfingrip.meshes.solid import SolidMesh

EVEN: Final = 1e-3
"""Area by which an outline may differ from that of fewer corners, relative."""


def whole_solid(config: Config) -> SolidMesh:
    """Return the mesh of the whole finger at rest.

    Args:
        config: of the finger.
    """
    return solid(config.changed(mesh={"half": False}))


def links(mesh: SolidMesh, config: Config, ends_mm: Sequence[float]) -> tuple[Link, ...]:
    """Cut a finger into links.

    Args:
        mesh: of the whole finger.
        config: with the densities of its regions.
        ends_mm: z of the planes between links, from the clamp's to the tip's.

    Returns:
        The links, from clamp to tip.
    """
    density = np.full(len(mesh.cells), config.material.density_kg_m3)
    for name, rows in mesh.regions.items():
        density[rows] = config.material.of(name).density_kg_m3
    at, weights = CELL_QUADRATURE[mesh.shape]
    functions = cells.of_cell(mesh.shape.corners)
    corners = mesh.points[mesh.cells[:, : mesh.shape.corners]]
    filled = False
    while not filled:  # every link has points of its own
        parts = corners_of_parts(mesh.shape)
        at = np.einsum("qn,pni->qpi", functions.values(at), parts).reshape(-1, 3)
        weights = np.repeat(weights, PARTS) / PARTS
        places = np.einsum("qn,mni->qmi", functions.values(at), corners).reshape(-1, 3)
        filled = bool((np.histogram(places[:, 2], ends_mm)[0] > 0).all())
    jacobians = np.linalg.det(np.einsum("qnk,mni->qmki", functions.gradients(at), corners))
    masses = (weights[:, None] * jacobians * density / MM3_PER_M3).ravel()
    outer = np.unique(_outer(mesh))
    surface = mesh.points[outer]
    pieces = []
    for start, end in itertools.pairwise(ends_mm):
        inside = (places[:, 2] >= start) & (places[:, 2] < end)
        mass, x = masses[inside], places[inside]
        centre = mass @ x / mass.sum()
        second = np.einsum("n,ni,nj->ij", mass, x - centre, x - centre)
        inertia = np.trace(second) * np.eye(3) - second
        reach = 0.02 * (ends_mm[-1] - ends_mm[0])
        near = (surface[:, 2] >= start - reach) & (surface[:, 2] <= end + reach)
        pieces.append(
            Link(
                mass_kg=float(mass.sum()),
                centre_mm=tuple(centre),
                inertia_kg_mm2=tuple(inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]),
                section_mm=_outline(surface[near][:, :2]),
                from_mm=float(start),
                to_mm=float(end),
            )
        )
    return tuple(pieces)


def _outer(mesh: SolidMesh) -> np.ndarray:
    """Corners (n, 3 or 4) of the facets that are no cavity's."""
    inside = groups.cavities(mesh.facets)
    return np.concatenate(
        [
            facets[:, : mesh.shape.facet_corners]
            for name, facets in mesh.facets.items()
            if name not in inside and name != "symmetry" and len(facets)
        ]
    )


def _outline(points: np.ndarray) -> tuple[tuple[float, float], ...]:
    """Corners of the convex outline, without those that hardly change its area."""
    corners = points[ConvexHull(points).vertices]
    area = ConvexHull(points).volume
    while len(corners) > 4:
        before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        one, other = corners - before, after - before
        areas = np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) / 2
        if areas.min() > EVEN * area:
            break
        corners = np.delete(corners, areas.argmin(), axis=0)
    return tuple((float(x), float(y)) for x, y in corners)


@dataclass(frozen=True)
class BoundSkin:
    """Triangles of a finger's outside, each corner of which moves with one or two links.

    Attributes:
        points_mm: (n, 3) at rest.
        triangles: (m, 3) rows of points.
        weights: (links, n) shares of the links in a point's motion; they sum to 1.
    """

    points_mm: np.ndarray
    triangles: np.ndarray
    weights: np.ndarray


def skin(mesh: SolidMesh, ends_mm: Sequence[float]) -> BoundSkin:
    """Bind a finger's outside to its links.

    Args:
        mesh: of the whole finger.
        ends_mm: z of the planes between links, from the clamp's to the tip's.

    Returns:
        The skin; between the middles of two links a point moves with both.
    """
    outer = _outer(mesh)
    if outer.shape[1] == 4:
        outer = np.concatenate([outer[:, [0, 1, 2]], outer[:, [0, 2, 3]]])
    used, triangles = np.unique(outer, return_inverse=True)
    points, ends = mesh.points[used], np.asarray(ends_mm)
    middles = (ends[1:] + ends[:-1]) / 2
    hats = np.eye(len(middles))
    weights = np.stack([np.interp(points[:, 2], middles, hat) for hat in hats])
    return BoundSkin(points, triangles.reshape(-1, 3), weights)
