"""Shapes of elements, their shape functions, and the step to second order."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from dolfingrip.meshes import cells
from dolfingrip.meshes.cells import (
    BY_NODES,
    FACET_CORNERS,
    HEXAHEDRON,
    TETRAHEDRON,
    CellShape,
    ShapeFunctions,
)
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh, second_order


@pytest.mark.parametrize("shape", [TETRAHEDRON, HEXAHEDRON])
def test_faces_and_spokes_of_the_reference(shape: CellShape) -> None:
    """Faces look outward, the nodes amid their edges are there, spokes are right-handed edges."""
    x = np.concatenate([shape.reference, shape.reference[shape.edges].mean(axis=1)])
    corners = shape.facet_corners
    for face in shape.faces:
        a, b, c = x[face[:3]]
        assert np.cross(b - a, c - a) @ (a - shape.reference.mean(axis=0)) > 0
        middles = (x[face[:corners]] + x[np.roll(face[:corners], -1)]) / 2
        assert np.array_equal(x[face[corners:]], middles)
    joined = {frozenset(edge) for edge in shape.edges.tolist()}
    for corner, others in enumerate(shape.spokes):
        assert np.linalg.det(x[others] - x[corner]) > 0
        assert all(frozenset((corner, other)) in joined for other in others.tolist())


@pytest.mark.parametrize("nodes", BY_NODES)
def test_shape_functions_of_elements(nodes: int) -> None:
    shape = BY_NODES[nodes]
    x = np.concatenate([shape.reference, shape.reference[shape.edges].mean(axis=1)])[:nodes]
    hold_polynomials(cells.of_cell(nodes), x, shape.order(nodes))


@pytest.mark.parametrize("nodes", FACET_CORNERS)
def test_shape_functions_of_facets(nodes: int) -> None:
    corners = np.array([[0, 0], [1, 0], [0, 1]] if nodes % 3 == 0 else HEXAHEDRON.reference[:4, :2])
    x = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2])[:nodes]
    hold_polynomials(cells.of_facet(nodes), x, 1 if nodes < 5 else 2)


def hold_polynomials(functions: ShapeFunctions, nodes: np.ndarray, order: int) -> None:
    """1 at one node; values and gradients of the order's polynomials are exact anywhere."""
    assert functions.values(nodes) == pytest.approx(np.eye(len(nodes)), abs=1e-12)
    seed = 3
    print(f"seed {seed}")
    at = np.random.default_rng(seed).uniform(0, 1, (5, nodes.shape[1]))
    for powers in product(range(order + 1), repeat=nodes.shape[1]):
        if sum(powers) > order:
            continue
        nodal = (nodes**powers).prod(axis=1)
        assert functions.values(at) @ nodal == pytest.approx((at**powers).prod(axis=1), abs=1e-12)
        for axis, power in enumerate(powers):
            lower = np.array(powers)
            lower[axis] = max(power - 1, 0)
            exact = power * (at**lower).prod(axis=1)
            assert functions.gradients(at)[:, :, axis] @ nodal == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize("name", ["half", "bricks"])
def test_second_order_keeps_the_mesh(name: str, request: pytest.FixtureRequest) -> None:
    mesh = request.getfixturevalue(name)
    assert isinstance(mesh, SolidMesh)
    found = second_order(mesh)
    assert found.order == 2
    corners = mesh.shape.corners
    assert np.array_equal(found.points[: len(mesh.points)], mesh.points)
    assert np.array_equal(found.cells[:, :corners], mesh.cells)
    edges = {frozenset(e) for e in mesh.cells[:, mesh.shape.edges].reshape(-1, 2).tolist()}
    assert len(found.points) == len(mesh.points) + len(edges)
    ends = found.points[found.cells[:, mesh.shape.edges]].mean(axis=2)
    assert np.array_equal(found.points[found.cells[:, corners:]], ends)
    for name, facets in mesh.facets.items():
        number = facets.shape[1]
        assert found.facets[name].shape == (len(facets), 2 * number)
        assert np.array_equal(
            np.sort(found.facets[name][:, :number], axis=1), np.sort(facets, axis=1)
        )
    one, two = check(mesh), check(found)
    assert two.volume_mm3 == pytest.approx(one.volume_mm3, rel=1e-12)
    assert two.cavity_mm3 == pytest.approx(one.cavity_mm3, rel=1e-12)
    with pytest.raises(MeshError, match="of order 2; allowed: order 1"):
        second_order(found)
