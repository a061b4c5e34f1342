"""The tip's mean displacement from nodal values, by which all programs are compared."""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes import cells
from dolfingrip.meshes.groups import TIP
from dolfingrip.meshes.measures import FACET_QUADRATURE
from dolfingrip.meshes.solid import SolidMesh


def mean_displacement(mesh: SolidMesh, displacement: np.ndarray) -> np.ndarray:
    """(3,) mean over the tip face's area (mm), as ``tip_x_mm`` and ``tip_z_mm`` are.

    Args:
        mesh: with a plane tip face, where the means are exact, of first or second order.
        displacement: (n, 3) at the mesh's points, mm; only those of the tip are used.
    """
    facets = mesh.facets[TIP]
    nodes = facets.shape[1]
    at, weights = FACET_QUADRATURE[mesh.shape.facet_corners]
    functions = cells.of_facet(nodes)
    along = np.einsum("qnj,kni->jqki", functions.gradients(at), mesh.points[facets])
    area = weights[:, None] * np.linalg.norm(np.cross(along[0], along[1]), axis=2)
    moved = np.einsum("qn,kni->qki", functions.values(at), displacement[facets])
    mean: np.ndarray = np.einsum("qk,qki->i", area, moved) / area.sum()
    return mean
