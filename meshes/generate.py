"""Meshes of the finger from its dimensions and a resolution."""

from __future__ import annotations

import math

import gmsh

from dolfingrip.config import Finger, Mesh
from dolfingrip.meshes import finger as geometry
from dolfingrip.meshes.gmsh_model import current_mesh, session
from dolfingrip.meshes.grading import concave_curves, size_field
from dolfingrip.meshes.solid import MeshError, SolidMesh

_MESH_OPTIONS = {
    "Mesh.MeshSizeExtendFromBoundary": 0.0,  # the size field alone rules
    "Mesh.MeshSizeFromPoints": 0.0,
    "Mesh.MeshSizeFromCurvature": 0.0,
    "Mesh.Algorithm": 6.0,
    "Mesh.Algorithm3D": 1.0,
    "Mesh.Optimize": 1.0,
}

TARGET_TOLERANCE = 0.01
"""Largest relative miss of ``mesh.target_elements``."""

_TRIES = 20


def finger_mesh(finger: Finger, mesh: Mesh) -> SolidMesh:
    """Mesh a finger.

    Parameters
    ----------
    finger
        Dimensions.
    mesh
        Half or whole, sizes or target number of elements, order of the elements.

    Returns
    -------
    SolidMesh
        Points in mm.

    Raises
    ------
    MeshError
        Where Gmsh fails, or the target number of elements is not met within 1 %.
    """
    with session("mesh of the finger"):
        for name, value in _MESH_OPTIONS.items():
            gmsh.option.setNumber(name, value)
        geometry.build(finger, mesh.half)
        curves: list[int] = []
        if mesh.edge_size_mm is not None:
            _tetrahedra(mesh, curves, 1.0)
            curves = concave_curves()
        if mesh.target_elements is None:
            _tetrahedra(mesh, curves, 1.0)
        else:
            _aim(mesh, curves, mesh.target_elements)
        if mesh.order == 2:
            gmsh.model.mesh.setOrder(2)
        return current_mesh()


def _tetrahedra(mesh: Mesh, curves: list[int], scale: float) -> int:
    """Mesh with both sizes scaled; the number of tetrahedra."""
    gmsh.model.mesh.clear()
    edge_size = mesh.size_mm if mesh.edge_size_mm is None else mesh.edge_size_mm
    size_field(curves, scale * mesh.size_mm, scale * edge_size)
    gmsh.model.mesh.generate(3)
    return len(gmsh.model.mesh.getElementsByType(4)[0])


def _aim(mesh: Mesh, curves: list[int], target: int) -> None:
    """Mesh with sizes scaled such that the number of tetrahedra meets the target.

    A secant in log(size) and log(count), kept between the nearest sizes known to give
    too many and too few elements.
    """
    tried: list[tuple[float, float]] = []  # log scale, log(count / target)
    log_scale, slope = 0.0, -2.5
    for _ in range(_TRIES):
        count = _tetrahedra(mesh, curves, math.exp(log_scale))
        miss = math.log(count / target)
        if abs(count - target) <= TARGET_TOLERANCE * target:
            return
        tried.append((log_scale, miss))
        log_scale -= miss / slope
    nearest = min(tried, key=lambda point: abs(point[1]))
    raise MeshError(
        f"mesh.target_elements = {target}: not met within 1 %; "
        f"nearest: {round(target * math.exp(nearest[1]))} elements"
    )
