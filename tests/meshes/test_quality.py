"""The checks: each defect is refused, and the figures are right where they are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from dolfingrip.meshes import measures
from dolfingrip.meshes.cells import TETRAHEDRON
from dolfingrip.meshes.measures import enclosed_volume
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh


def regular() -> SolidMesh:
    """The regular tetrahedron with edges √8."""
    points = np.array([[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]], dtype=float)
    return SolidMesh(points, np.array([[0, 1, 2, 3]]), {})


def swap_corners(mesh: SolidMesh) -> SolidMesh:
    tetrahedra = mesh.cells.copy()
    tetrahedra[7, [0, 1]] = tetrahedra[7, [1, 0]]
    return replace(mesh, cells=tetrahedra)


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
        for face in mesh.cells[:, :3]
        if not any(np.isin(f, face).all(axis=1).any() for f in mesh.facets.values())
    )
    skin = np.concatenate([mesh.facets["skin"], [inner]])
    return replace(mesh, facets={**mesh.facets, "skin": skin})


def turn_facet(mesh: SolidMesh) -> SolidMesh:
    cavity = mesh.facets["cavity"].copy()
    cavity[3] = cavity[3, ::-1]
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
        (swap_corners, r"Jacobian of tetrahedron 7 is -.* of 1 in all not positive"),
        (drop_group, "missing group tip; needed: cavity, clamp, skin, tip"),
        (drop_facet, "1 facets in no group; allowed: exactly one of"),
        (share_facet, "1 facets in more than one group"),
        (inner_facet, "1 facets in a group but inside the solid"),
        (turn_facet, "1 facets seen from inside"),
        (open_cavity, "cavity: not closed, 3 edges with one facet"),
        (exchange_inside_and_outside, "cavity: its facets enclose no hollow"),
        (lift_symmetry, "symmetry: 0.1 mm off its plane; allowed: y = 0"),
    ],
)
def test_defects_are_named(
    half: SolidMesh, spoil: Callable[[SolidMesh], SolidMesh], complaint: str
) -> None:
    check(half)
    with pytest.raises(MeshError, match=complaint) as caught:
        check(spoil(half))
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
