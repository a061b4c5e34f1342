"""Gmsh's meshes of the finger in tetrahedra, from its dimensions and a resolution."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import gmsh
import numpy as np

from dolfingrip.meshes import solid_model
from dolfingrip.meshes.gmsh_model import current_mesh, numbered_nodes, session
from dolfingrip.meshes.solid import MOST_ELEMENTS, MeshError, SolidMesh, boundary, faces
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


COARSE: Final = 0.25
"""Element size, as part of the finger's depth, of the mesh that shows concave edges."""

FLAT_SINE: Final = 1e-3
"""Sine of the angle below which two faces count as one smooth face."""

GROWTH: Final = 0.5
"""Growth of the element size (mm) with each mm of distance from a concave edge."""


TOLERANCE: Final = 0.01
"""Largest relative difference from the target."""

TRIES: Final = 20
"""Meshes, and bisections, at most."""

SLOPES: Final = (-3.5, -1.0)
"""Range of d log(count) / d log(size): -2 in a thin wall, -3 in a thick solid."""

LARGEST_STEP: Final = 1.5
"""Longest step of log(size)."""

CLOSE: Final = 0.02
"""Bracket of log(size) below which the position of the change of size is bisected instead."""


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

        def tetrahedra(below: float, above: float, share: float) -> int:
            scale = step_along_z(below, above, share * finger.length_mm)
            set_sizes(curves, size, edge_size, GROWTH, scale)
            return _generate()

        if mesh.target_elements is None:
            _limit(size, mesh.edge_size_mm, *expected_elements(curves, size, edge_size, GROWTH))
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
    size = COARSE * finger.depth_mm
    set_sizes([], size, size, GROWTH)
    _generate()
    return concave_curves()


def _generate() -> int:
    """Set the sizes and mesh; return the number of tetrahedra."""
    gmsh.model.mesh.clear()
    gmsh.model.mesh.generate(3)
    return len(gmsh.model.mesh.getElementsByType(4)[0])


def meet(target: int, mesh: Callable[[float, float, float], int]) -> None:
    """Mesh until the number of elements is within 1 % of the target.

    The bellows are alike, so the count jumps by more than 1 % if the number of elements on an edge
    changes in all of them at once. The search therefore has two stages. The first is a secant
    method in log(size) and log(count), between the nearest sizes that gave too many and too few
    elements. The second takes these two sizes and bisects the place along the finger where the
    smaller one ends and the larger one begins.

    Args:
        target: wanted number of elements.
        mesh: makes a mesh with sizes scaled by its first argument up to a part of the length, its
            third argument, and by its second argument beyond; returns the number of elements.

    Raises:
        MeshError: if the target is missed.
    """
    tried: list[int] = []

    def miss(below: float, above: float, share: float) -> float:
        tried.append(mesh(math.exp(below), math.exp(above), share))
        return math.log(tried[-1] / target)

    def met() -> bool:
        return abs(tried[-1] - target) <= TOLERANCE * target

    bracket = _bracket(miss)
    if bracket is not None:
        fine, coarse = bracket
        low, high = 0.0, 1.0
        for _ in range(TRIES):
            if met():
                return
            share = (low + high) / 2
            if miss(fine, coarse, share) < 0:
                low = share
            else:
                high = share
    if not met():
        nearest = min(tried, key=lambda count: abs(count - target))
        raise MeshError(
            f"mesh.target_elements = {target}: cannot be met within {TOLERANCE:.0%} "
            f"with these dimensions and sizes; nearest allowed: {nearest}"
        )


def _bracket(miss: Callable[[float, float, float], float]) -> tuple[float, float] | None:
    """Close log scales with too many and too few elements; None if met or not found."""
    within = math.log1p(TOLERANCE) * 0.99
    fine = coarse = None
    scale, slope = 0.0, -2.1  # walls thinner than the elements
    value = miss(scale, scale, 1.0)
    for _ in range(TRIES):
        if abs(value) <= within:
            return None
        if value > 0:
            fine = scale
        else:
            coarse = scale
        step = min(max(-value / slope, -LARGEST_STEP), LARGEST_STEP)
        new = scale + step
        if fine is not None and coarse is not None:
            if abs(coarse - fine) <= CLOSE:
                return fine, coarse
            # a secant that hardly moves an end is no better than this end
            if not fine + within / 4 <= new <= coarse - within / 4:
                new = (fine + coarse) / 2
        before, scale = (scale, value), new
        value = miss(scale, scale, 1.0)
        slope = (value - before[1]) / (scale - before[0])
        slope = min(max(slope, SLOPES[0]), SLOPES[1])
    return None


def concave_curves(flat_sine: float = FLAT_SINE) -> list[int]:
    """Curves of the current, meshed Gmsh model where the dihedral angle exceeds 180°.

    At a concave edge each of the two faces rises above the plane of the other. The mesh gives the
    outward normals, so the test finds edges of the cavity and outer ones. A coarse mesh is enough.

    Args:
        flat_sine: sine of the angle below which two faces count as one smooth face.

    Returns:
        Tags of the curves.
    """
    places, row = numbered_nodes()
    points = places[row]
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
        if height > flat_sine * np.linalg.norm(apex - a):
            concave.append(curve)
    return concave


def set_sizes(
    curves: list[int], size: float, edge_size: float, growth: float, scale: str = "1"
) -> None:
    """Set the element sizes of the current Gmsh model.

    Args:
        curves: tags of the curves at which the mesh is refined.
        size: element size away from the curves (mm).
        edge_size: element size at the curves (mm).
        growth: growth of the element size (mm) with each mm of distance from a curve.
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
        field.setNumber(2, "DistMax", (size - edge_size) / growth)
        unscaled = "F2"
    field.add("MathEval", 3)
    field.setString(3, "F", f"{unscaled} * ({scale})")
    field.setAsBackgroundMesh(3)


def step_along_z(below: float, above: float, z: float) -> str:
    """A ``scale`` for :func:`set_sizes` with one value below ``z`` (mm) and another above."""
    if below == above:
        return f"{below:.17g}"
    return f"{below:.17g} + ({above - below:.17g}) * step(z - {z:.17g})"


def expected_elements(
    curves: list[int], size: float, edge_size: float, growth: float
) -> tuple[float, float]:
    """Rough number of tetrahedra in the bulk and around the concave edges.

    A regular tetrahedron with edges h fills 0.118 h³. Around an edge the solid fills three
    quarters of a circle, in which the size grows with the distance.

    Args:
        curves, size, edge_size, growth: as in :func:`set_sizes`.
    """
    volume = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
    length = sum(gmsh.model.occ.getMass(1, curve) for curve in curves)
    around = 0.75 * math.pi / growth**2 * length * max(1 / edge_size - 1 / size, 0)
    return volume / (0.118 * size**3), around / 0.118
