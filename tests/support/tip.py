"""The tip's mean displacement from nodal values, by which all programs are compared; its angle."""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes import cells
from dolfingrip.meshes.groups import TIP
from dolfingrip.meshes.measures import FACET_QUADRATURE
from dolfingrip.meshes.solid import SolidMesh


def mean_displacement(mesh: SolidMesh, displacement: np.ndarray) -> np.ndarray:
    """Mean (3,) over the tip face's area (mm), as ``tip_x_mm`` and ``tip_z_mm`` are.

    Args:
        mesh: with a plane tip face, where the means are exact, of first or second order.
        displacement: (n, 3) at the mesh's points, mm; only those of the tip are used.
    """
    facets = mesh.facets[TIP]
    at, weights = FACET_QUADRATURE[mesh.shape.facet_corners]
    functions = cells.of_facet(facets.shape[1])
    area = weights[:, None] * np.linalg.norm(_normals(mesh, mesh.points), axis=2)
    moved = np.einsum("qn,kni->qki", functions.values(at), displacement[facets])
    mean: np.ndarray = np.einsum("qk,qki->i", area, moved) / area.sum()
    return mean


def area_vector(mesh: SolidMesh, displacement: np.ndarray) -> np.ndarray:
    """Area (3,) of the deformed tip face (mm²), outwards, whose turn is ``angle_deg``.

    Args:
        mesh: as of :func:`mean_displacement`.
        displacement: likewise.
    """
    _, weights = FACET_QUADRATURE[mesh.shape.facet_corners]
    now, before = (
        np.einsum("q,qki->ki", weights, _normals(mesh, points))
        for points in (mesh.points + displacement, mesh.points)
    )
    # facets may be listed either way round
    outwards: np.ndarray = np.sign(before[:, 2]) @ now
    return outwards


def _normals(mesh: SolidMesh, points: np.ndarray) -> np.ndarray:
    """Normals (places, facets, 3) of the tip's facets, as long as their area."""
    facets = mesh.facets[TIP]
    at, _ = FACET_QUADRATURE[mesh.shape.facet_corners]
    gradients = cells.of_facet(facets.shape[1]).gradients(at)
    along = np.einsum("qnj,kni->jqki", gradients, points[facets])
    return np.asarray(np.cross(along[0], along[1]))
