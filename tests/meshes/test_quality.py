"""The checks: each defect is refused, and the figures are right where they are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support import hollow_box

from dolfingrip.meshes import measures
from dolfingrip.meshes.cells import HEXAHEDRON, TETRAHEDRON
from dolfingrip.meshes.measures import enclosed_volume
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh

REVERSED = {3: [2, 1, 0], 4: [3, 2, 1, 0], 8: [3, 2, 1, 0, 6, 5, 4, 7]}
"""Nodes of a facet seen from the other side."""


def regular() -> SolidMesh:
    """The regular tetrahedron with edges √8."""
    points = np.array([[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]], dtype=float)
    return SolidMesh(points, np.array([[0, 1, 2, 3]]), {})


def swap_corners(mesh: SolidMesh) -> SolidMesh:
    cells = mesh.cells.copy()
    cells[7, [0, 1]] = cells[7, [1, 0]]
    return replace(mesh, cells=cells)


def drop_group(mesh: SolidMesh) -> SolidMesh:
    return replace(mesh, facets={n: f for n, f in mesh.facets.items() if n != "tip"})


def drop_facet(mesh: SolidMesh) -> SolidMesh:
    return replace(mesh, facets={**mesh.facets, "cavity": mesh.facets["cavity"][1:]})


def share_facet(mesh: SolidMesh) -> SolidMesh:
    both = np.concatenate([mesh.facets["tip"], mesh.facets["skin"][:1]])
    return replace(mesh, facets={**mesh.facets, "tip": both})


def inner_facet(mesh: SolidMesh) -> SolidMesh:
    inner = next(
        face
        for face in mesh.cells[:, mesh.shape.face_corners[0]]
        if not any(np.isin(f[:, : len(face)], face).all(axis=1).any() for f in mesh.facets.values())
    )
    # a check of the corners, so the nodes amid the edges may be any
    nodes = np.resize(inner, mesh.facets["skin"].shape[1])
    skin = np.concatenate([mesh.facets["skin"], [nodes]])
    return replace(mesh, facets={**mesh.facets, "skin": skin})


def turn_facet(mesh: SolidMesh) -> SolidMesh:
    cavity = mesh.facets["cavity"].copy()
    cavity[3] = cavity[3, REVERSED[cavity.shape[1]]]
    return replace(mesh, facets={**mesh.facets, "cavity": cavity})


def open_cavity(mesh: SolidMesh) -> SolidMesh:
    cavity, skin = mesh.facets["cavity"], mesh.facets["skin"]
    moved = {"cavity": cavity[1:], "skin": np.concatenate([skin, cavity[:1]])}
    return replace(mesh, facets={**mesh.facets, **moved})


def exchange_inside_and_outside(mesh: SolidMesh) -> SolidMesh:
    outer = ("skin", "clamp", "tip")
    facets = dict(mesh.facets)
    cavity, facets["skin"] = facets["cavity"], facets["skin"][:0]
    first, second, rest = np.split(cavity, [1, 2])
    inside = {"clamp": first, "tip": second, "skin": rest}
    facets["cavity"] = np.concatenate([mesh.facets[name] for name in outer])
    return replace(mesh, facets={**facets, **inside})


def lift_symmetry(mesh: SolidMesh) -> SolidMesh:
    return replace(mesh, points=mesh.points + np.array([0, 0.1, 0]))


@pytest.mark.parametrize(
    ("spoil", "complaint"),
    [
        (swap_corners, r"Jacobian of \w+hedron 7 is -.* of 1 in all not positive"),
        (drop_group, "missing group tip; needed: cavity, clamp, skin, tip"),
        (drop_facet, "1 facets in no group; allowed: exactly one of"),
        (share_facet, "1 facets in more than one group"),
        (inner_facet, "1 facets in a group but inside the solid"),
        (turn_facet, "1 facets seen from inside"),
        (open_cavity, "cavity: not closed, [34] edges with one facet"),
        (exchange_inside_and_outside, "cavity: its facets enclose no hollow"),
        (lift_symmetry, "symmetry: 0.1 mm off its plane; allowed: y = 0"),
    ],
)
@pytest.mark.parametrize("name", ["half", "bricks", "bricks_second_order"])
def test_defects_are_named(
    name: str,
    spoil: Callable[[SolidMesh], SolidMesh],
    complaint: str,
    request: pytest.FixtureRequest,
) -> None:
    mesh = request.getfixturevalue(name)
    check(mesh)
    with pytest.raises(MeshError, match=complaint) as caught:
        check(spoil(mesh))
    assert "\n" not in str(caught.value)


def test_curved_element_folded_over(half_second_order: SolidMesh) -> None:
    points = half_second_order.points.copy()
    element = half_second_order.cells[20]
    points[element[4]] = points[element[3]]
    with pytest.raises(MeshError, match="Jacobian of tetrahedron"):
        check(replace(half_second_order, points=points))


def test_figures_of_the_regular_tetrahedron() -> None:
    mesh = regular()
    assert measures.scaled_jacobians(mesh) == pytest.approx(1)
    assert np.degrees(measures.dihedral_angles(mesh)) == pytest.approx(70.528779, abs=1e-6)
    assert measures.jacobians(mesh) == pytest.approx(6 * 8 / 3)


def test_jacobians_of_a_curved_element() -> None:
    straight = regular()
    points = np.concatenate([straight.points, straight.points[TETRAHEDRON.edges].mean(axis=1)])
    element = np.arange(10)[None]
    assert measures.jacobians(SolidMesh(points, element, {})) == pytest.approx(16)
    # x' = x + x²/10 maps a quadratic element exactly: J' = J (1 + x/5)
    points[:, 0] += points[:, 0] ** 2 / 10
    bent = measures.jacobians(SolidMesh(points, element, {}))
    assert [bent.min(), bent.max()] == pytest.approx([16 * 0.8, 16 * 1.2])


def test_volume_within_curved_facets(half_second_order: SolidMesh) -> None:
    """A volume-keeping quadratic map is represented exactly where the mesh was straight."""
    points = half_second_order.points.copy()
    points[:, 0] += points[:, 2] ** 2 / 500 + points[:, 1] ** 2 / 50
    straight, bent = check(half_second_order), check(replace(half_second_order, points=points))
    assert bent.volume_mm3 == pytest.approx(straight.volume_mm3, rel=1e-9)
    assert bent.cavity_mm3 == pytest.approx(straight.cavity_mm3, rel=1e-9)


def test_volume_of_the_cavity_does_not_depend_on_x_and_z(half: SolidMesh) -> None:
    cavity = half.facets["cavity"]
    moved = enclosed_volume(half.points + np.array([3, 0, -7]), cavity)
    assert moved == pytest.approx(enclosed_volume(half.points, cavity), rel=1e-9)


def test_summary_is_one_line_with_units(whole: SolidMesh) -> None:
    summary = check(whole).summary()
    assert "\n" not in summary
    assert f"{len(whole.cells)} tetrahedra of order 1" in summary
    assert "solid 19016.4 mm³, cavity 7095.6 mm³" in summary


def brick(nodes: int = 8) -> SolidMesh:
    """A box of 2 mm × 3 mm × 4 mm."""
    corners = HEXAHEDRON.reference * [2.0, 3.0, 4.0]
    points = np.concatenate([corners, corners[HEXAHEDRON.edges].mean(axis=1)])[:nodes]
    return SolidMesh(points, np.arange(nodes)[None], {})


@pytest.mark.parametrize("nodes", [8, 20])
def test_figures_of_a_brick(nodes: int) -> None:
    mesh = brick(nodes)
    assert measures.jacobians(mesh) == pytest.approx(24)
    assert measures.scaled_jacobians(mesh) == pytest.approx(1)
    assert np.degrees(measures.dihedral_angles(mesh)) == pytest.approx(90)
    assert sorted(measures.edge_lengths(mesh)[0]) == pytest.approx([2] * 4 + [3] * 4 + [4] * 4)
    assert measures.centroid(mesh) == pytest.approx([1, 1.5, 2])


def test_figures_of_a_sheared_brick() -> None:
    """x' = x + z tan 30°: angles of 60° and 120° along y, and the volume stays."""
    mesh = brick()
    mesh.points[:, 0] += mesh.points[:, 2] / np.sqrt(3)
    assert measures.jacobians(mesh) == pytest.approx(24)
    assert measures.scaled_jacobians(mesh) == pytest.approx(np.cos(np.pi / 6))
    angles = np.degrees(measures.dihedral_angles(mesh))
    assert np.unique(angles.round(9)).tolist() == pytest.approx([60, 90, 120])


def test_jacobians_of_a_curved_brick() -> None:
    """x' = x + x²/10 maps the element of second order exactly: J' = J (1 + x/5)."""
    mesh = brick(20)
    mesh.points[:, 0] += mesh.points[:, 0] ** 2 / 10
    bent = measures.jacobians(mesh)
    assert [bent.min(), bent.max()] == pytest.approx([24, 24 * 1.4])


def test_inverted_corner_of_a_brick_is_seen() -> None:
    """A corner pushed beyond the plane of its neighbours turns the element inside out there."""
    mesh = brick()
    assert measures.jacobians(mesh).min() > 0
    mesh.points[6] = mesh.points[[2, 5, 7]].mean(axis=0) - [0.01, 0.01, 0.01]
    assert measures.jacobians(mesh).min() < 0
    assert measures.scaled_jacobians(mesh)[0] < 0


def test_centroid_of_a_widening_brick() -> None:
    """x ≤ 1 + z on the unit cube: volume 3/2, and moments 7/6, 3/4, 5/6."""
    points = HEXAHEDRON.reference.copy()
    points[:, 0] *= 1 + points[:, 2]
    widening = SolidMesh(points, np.arange(8)[None], {})
    assert measures.centroid(widening) == pytest.approx([7 / 9, 1 / 2, 5 / 9])


@pytest.mark.parametrize(
    ("name", "weights"),
    [
        ("bricks", np.array([1, 4, 1]) / 6),  # Simpson's rule
        ("bricks_second_order", np.array([19, 75, 50, 50, 75, 19]) / 288),  # Newton and Cotes'
    ],
)
def test_volume_within_warped_facets_is_that_of_the_elements(
    name: str, weights: np.ndarray, request: pytest.FixtureRequest
) -> None:
    mesh = request.getfixturevalue(name)
    seed = 11
    print(f"seed {seed}")
    shift = np.random.default_rng(seed).uniform(-0.1, 0.1, mesh.points.shape)
    shift[mesh.points[:, 1] == 0, 1] = 0
    warped = replace(mesh, points=mesh.points + shift)
    rule = np.einsum("i,j,k->ijk", weights, weights, weights).ravel()
    volume = (measures.jacobians(warped) @ rule).sum()
    assert abs(volume - hollow_box.VOLUME_MM3) > 0.01
    assert check(warped).volume_mm3 == pytest.approx(volume, rel=1e-12)


def test_summary_names_hexahedra(bricks_second_order: SolidMesh) -> None:
    quality = check(bricks_second_order)
    assert "48 hexahedra of order 2" in quality.summary()
    assert quality.volume_mm3 == pytest.approx(hollow_box.VOLUME_MM3, rel=1e-12)
    assert quality.cavity_mm3 == pytest.approx(hollow_box.CAVITY_MM3, rel=1e-12)
