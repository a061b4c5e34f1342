"""Element sizes: finer towards the concave edges of the solid, where stress concentrates."""

from __future__ import annotations

import math

import gmsh
import numpy as np

from dolfingrip.meshes.policy import GRADING
from dolfingrip.meshes.solid import boundary, faces


def concave_curves() -> list[int]:
    """Curves of the current, meshed Gmsh model where the dihedral angle exceeds 180°.

    At a concave edge each of the two faces rises above the plane of the other. The mesh gives the
    outward normals, so the test finds edges of the cavity and outer ones. A coarse mesh is enough.

    Returns:
        Tags of the curves.
    """
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    points = np.zeros((int(tags.max()) + 1, 3))
    points[tags.astype(np.int64)] = coordinates.reshape(-1, 3)
    tetrahedra = gmsh.model.mesh.getElementsByType(4)[1].astype(np.int64).reshape(-1, 4)
    facets = faces(tetrahedra)[boundary(tetrahedra)]
    concave = []
    for _, curve in gmsh.model.getEntities(1):
        line = gmsh.model.mesh.getElementsByType(1, curve)[1][:2].astype(np.int64)
        on_edge = np.isin(facets, line)
        pair = np.flatnonzero(on_edge.sum(axis=1) == 2)
        if len(pair) != 2:
            continue
        a, b, c = points[facets[pair[0]]]
        normal = np.cross(b - a, c - a)
        apex = points[facets[pair[1]][~on_edge[pair[1]]]][0]
        height = normal @ (apex - a) / np.linalg.norm(normal)
        if height > GRADING.flat_sine * np.linalg.norm(apex - a):
            concave.append(curve)
    return concave


def set_sizes(curves: list[int], size: float, edge_size: float, scale: str = "1") -> None:
    """Set the element sizes of the current Gmsh model.

    Args:
        curves: tags of the curves at which the mesh is refined.
        size: element size away from the curves (mm).
        edge_size: element size at the curves (mm).
        scale: factor on both, as an expression of Gmsh's MathEval field in x, y, z (mm).
    """
    field = gmsh.model.mesh.field
    for tag in field.list():
        field.remove(tag)
    unscaled = f"{size:.17g}"
    if curves and edge_size < size:
        lengths = [gmsh.model.occ.getMass(1, curve) for curve in curves]
        field.add("Distance", 1)
        field.setNumbers(1, "CurvesList", curves)
        # Gmsh takes the distance to the nearest one of these sampled points
        field.setNumber(1, "Sampling", min(max(20, round(2 * max(lengths) / edge_size)), 1000))
        field.add("Threshold", 2)
        field.setNumber(2, "InField", 1)
        field.setNumber(2, "SizeMin", edge_size)
        field.setNumber(2, "SizeMax", size)
        field.setNumber(2, "DistMin", 0)
        field.setNumber(2, "DistMax", (size - edge_size) / GRADING.growth)
        unscaled = "F2"
    field.add("MathEval", 3)
    field.setString(3, "F", f"{unscaled} * ({scale})")
    field.setAsBackgroundMesh(3)


def step_along_z(near: float, far: float, z: float) -> str:
    """A ``scale`` for :func:`set_sizes`: ``near`` below ``z`` (mm) and ``far`` above."""
    if near == far:
        return f"{near:.17g}"
    return f"{near:.17g} + ({far - near:.17g}) * step(z - {z:.17g})"


def expected_elements(curves: list[int], size: float, edge_size: float) -> tuple[float, float]:
    """Rough number of tetrahedra in the bulk and around the concave edges.

    A regular tetrahedron with edges h fills 0.118 h³. Around an edge the solid fills three
    quarters of a circle, in which the size grows with the distance.

    Args:
        curves, size, edge_size: as in :func:`set_sizes`.
    """
    volume = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
    length = sum(gmsh.model.occ.getMass(1, curve) for curve in curves)
    around = 0.75 * math.pi / GRADING.growth**2 * length * max(1 / edge_size - 1 / size, 0)
    return volume / (0.118 * size**3), around / 0.118
