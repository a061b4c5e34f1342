"""Gmsh's meshes of the finger in tetrahedra, from its dimensions and a resolution."""

from __future__ import annotations

import gmsh

from dolfingrip.meshes import solid_model
from dolfingrip.meshes.gmsh_model import current_mesh, session
from dolfingrip.meshes.grading import (
    concave_curves,
    expected_elements,
    set_sizes,
    step_along_z,
)
from dolfingrip.meshes.policy import GRADING
from dolfingrip.meshes.solid import MOST_ELEMENTS, MeshError, SolidMesh
from dolfingrip.meshes.target import meet
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.specimen import Mesh

_OPTIONS = {
    "Mesh.MeshSizeExtendFromBoundary": 0.0,  # the size field alone determines sizes
    "Mesh.MeshSizeFromPoints": 0.0,
    "Mesh.MeshSizeFromCurvature": 0.0,
    # the best algorithms of Debian's Gmsh: Frontal-Delaunay faces and a Delaunay solid, with every
    # tetrahedron below a quality of 0.6 improved; HXT takes 20 times as long
    "Mesh.Algorithm": 6.0,
    "Mesh.Algorithm3D": 1.0,
    "Mesh.Optimize": 1.0,
    "Mesh.OptimizeThreshold": 0.6,
}


def finger_mesh(finger: Geometry, mesh: Mesh) -> SolidMesh:
    """Mesh a finger.

    Args:
        finger: dimensions.
        mesh: half or whole, sizes or target number of elements, order of the elements.

    Returns:
        Points in mm.

    Raises:
        MeshError: if Gmsh fails, or the target number of elements is missed by more than 1 %.
    """
    size, edge_size = mesh.tetrahedra_mm()
    if edge_size > size:
        raise MeshError(
            f"mesh.edge_size_mm = {edge_size}: allowed: above 0 and up to size_mm = {size:g} mm"
        )
    with session("mesh of the finger", _OPTIONS):
        solid_model.build(finger, mesh.half)
        curves = _concave_curves(finger) if mesh.edge_size_mm is not None else []

        def tetrahedra(near: float, far: float, share: float) -> int:
            scale = step_along_z(near, far, share * finger.length_mm)
            set_sizes(curves, size, edge_size, scale)
            return _generate()

        if mesh.target_elements is None:
            _limit(size, mesh.edge_size_mm, *expected_elements(curves, size, edge_size))
            tetrahedra(1.0, 1.0, 1.0)
        else:
            meet(mesh.target_elements, tetrahedra)
        gmsh.model.mesh.optimize("Relocate3D", niter=3)
        if mesh.order == 2:
            gmsh.model.mesh.setOrder(2)
        return current_mesh()


def _limit(size: float, edge_size: float | None, bulk: float, at_edges: float) -> None:
    """Refuse sizes whose expected number of elements would fill the memory."""
    if bulk > MOST_ELEMENTS:
        least = size * (bulk / MOST_ELEMENTS) ** (1 / 3)
        raise MeshError(
            f"mesh.size_mm = {size}: about {bulk:.0e} tetrahedra; "
            f"allowed: at least {least:.2g} mm for this finger"
        )
    if edge_size is not None and at_edges > MOST_ELEMENTS:
        least = edge_size * at_edges / MOST_ELEMENTS
        raise MeshError(
            f"mesh.edge_size_mm = {edge_size}: about {at_edges:.0e} tetrahedra; "
            f"allowed: at least {least:.2g} mm for this finger"
        )


def _concave_curves(finger: Geometry) -> list[int]:
    set_sizes([], GRADING.coarse * finger.depth_mm, GRADING.coarse * finger.depth_mm)
    _generate()
    return concave_curves()


def _generate() -> int:
    """Set the sizes and mesh; return the number of tetrahedra."""
    gmsh.model.mesh.clear()
    gmsh.model.mesh.generate(3)
    return len(gmsh.model.mesh.getElementsByType(4)[0])
