"""Cast blocks and pneu-nets: volumes and groups by hand, and how their meshes follow dimensions."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from dolfingrip import config
from dolfingrip.config import ConfigError, Mesh
from dolfingrip.experiments.rigs.undeformed import load_domain, solid
from dolfingrip.meshes import files
from dolfingrip.meshes.dimensions import moved
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.measures import jacobians
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh, assemble, second_order
from dolfingrip.meshes.structured import structured_mesh
from dolfingrip.parameter import every
from dolfingrip.sections.geometry.bellows import Bellows
from dolfingrip.sections.geometry.cast import Cast
from dolfingrip.sections.geometry.pneunet import Pneunet
from dolfingrip.sections.geometry.round_bellows import RoundBellows
from dolfingrip.sections.tables import assignments

PAIR = ("cavity", "cavity_2")
SMALL = Mesh(size_mm=20, edge_size_mm=20)


def area(mesh: SolidMesh, name: str) -> float:
    """Of a group (mm²), whose facets are rectangles."""
    x = mesh.points[mesh.facets[name][:, :4]]
    return float(np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 3] - x[:, 0]), axis=1).sum())


def volume(mesh: SolidMesh, region: str) -> float:
    """Of a region of bricks (mm³)."""
    return float(jacobians(mesh)[mesh.regions[region]].mean(axis=1).sum())


@pytest.mark.parametrize("half", [True, False])
def test_the_measured_cast_block(half: bool) -> None:
    """Five chambers of 8 × 8 × 2 mm in a block of 52 × 22 × 15 mm, walls of 7 mm, film of 0.5."""
    mesh = structured_mesh(Cast(), SMALL.model_copy(update={"half": half}))
    found, part = check(mesh), 0.5 if half else 1.0
    cavity = 5 * 8 * 8 * 2 + 4 * 7 * 2 * 2 + 7 * 2 * 2
    assert found.cavity_mm3 == pytest.approx(part * cavity, rel=1e-12)
    assert found.volume_mm3 == pytest.approx(part * (52 * 22 * 15.5 - cavity), rel=1e-12)
    assert volume(mesh, "film") == pytest.approx(part * 52 * 22 * 0.5, rel=1e-12)
    assert sum(len(rows) for rows in mesh.regions.values()) == len(mesh.cells)
    assert area(mesh, "clamp") == pytest.approx(part * (22 * 15.5 - 2 * 2), rel=1e-12)
    assert area(mesh, "tip") == pytest.approx(part * 22 * 15.5, rel=1e-12)
    assert ("symmetry" in mesh.facets) is half


def test_seven_chambers_are_longer() -> None:
    assert Cast(chambers=7).length_mm == 70.0


def test_a_cup_holds_the_sides() -> None:
    plain, held = (structured_mesh(Cast(cup_mm=cup), SMALL) for cup in (0.0, 5.0))
    assert np.ptp(held.points[:, 2]) == pytest.approx(57.0)
    sides = 5 * (15.5 + 11 + 11)  # of a half: one side, film and roof
    assert area(held, "clamp") - area(plain, "clamp") == pytest.approx(sides, rel=1e-12)
    assert area(held, "skin") == pytest.approx(area(plain, "skin"), rel=1e-12)


def test_a_closed_tube() -> None:
    closed = check(structured_mesh(Cast(tube=False), SMALL))
    assert closed.cavity_mm3 == pytest.approx((5 * 128 + 4 * 28) / 2, rel=1e-12)


@pytest.mark.parametrize("tube", [True, False])
def test_pneunet(tube: bool) -> None:
    shape = Pneunet(chambers=3, tube=tube)
    mesh = structured_mesh(shape, SMALL)
    found = check(mesh)
    length = 10 + 3 * 9 + 2 * 1 + 2
    cavity = 3 * 6 * 16 * 10 + 2 * 4 * 2 * 2 + tube * 11.5 * 2 * 2
    gaps = 2 * 1 * 20 * 8  # down to the tunnel's roof
    assert shape.length_mm == length
    assert found.cavity_mm3 == pytest.approx(cavity / 2, rel=1e-12)
    whole = length * 20 * 15.2 - cavity - gaps
    assert found.volume_mm3 == pytest.approx(whole / 2, rel=1e-12)
    assert volume(mesh, "paper") == pytest.approx(length * 20 * 0.2 / 2, rel=1e-12)
    assert volume(mesh, "base") == pytest.approx(length * 20 * 3 / 2, rel=1e-12)


def test_a_tube_through_the_clamp() -> None:
    """Of bellows, in both shapes of cells, and of both round ones: its volume leaves the block."""
    for mesher in (structured_mesh, finger_mesh):
        sealed, open_ = (
            check(mesher(Bellows(bellows=2, length_mm=40, tube_mm=wide), Mesh(size_mm=8.0)))
            for wide in (0.0, 2.0)
        )
        grown = open_.cavity_mm3 - sealed.cavity_mm3
        assert grown == pytest.approx((12 + 1.6) * 2 * 2 / 2, rel=1e-9)
        assert sealed.volume_mm3 - open_.volume_mm3 == pytest.approx(grown, rel=1e-9)
    around = RoundBellows(
        convolutions=1, tube_mm=3.0, wall_mm=2.0, neck_radius_mm=4.0, pitch_mm=9.0
    )
    mesh = finger_mesh(around, Mesh(size_mm=3.0))
    assert set(PAIR) < set(mesh.facets)
    rims = [mesh.points[mesh.facets[name]][..., 2].min() for name in PAIR]
    assert rims == pytest.approx([0.0, 0.0], abs=1e-9)
    check(mesh)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "finger.tube_mm=12",
            "finger.tube_mm = 12.0: too wide; allowed: above 0 and up to 10.9 mm",
        ),
        ("round_bellows.tube_mm=5", "round_bellows.tube_mm = 5.0: too wide; allowed: .* 4.4 mm"),
    ],
)
def test_a_tube_wider_than_the_cavity(text: str, said: str) -> None:
    kind = () if text.startswith("finger") else ("finger.kind=round_bellows",)
    with pytest.raises(ConfigError, match=said):
        config.load(None, assignments([*kind, text]))


def test_regions_stay_with_their_cells() -> None:
    mesh = structured_mesh(Cast(), SMALL)
    quadratic = second_order(mesh)
    again = assemble(quadratic.points, quadratic.cells, quadratic.facets, quadratic.regions)
    assert volume(again, "film") == pytest.approx(volume(mesh, "film"), rel=1e-12)


@pytest.mark.parametrize("kind", ["cast", "pneunet"])
def test_a_mesh_follows_every_dimension(kind: str) -> None:
    """Moved by a tenth, a mesh has the faces of the other dimensions, cells and volumes right."""
    base = config.from_dict({"finger": {"kind": kind}, kind: {"chambers": 2}})
    mesh = structured_mesh(base.geometry, SMALL)
    parameters = [p for p in every(base) if p.key.startswith(kind)]
    assert len(parameters) >= 7
    for parameter in parameters:
        step = 0.1 * (parameter.value(base) or 1.0)
        changed = parameter.at(base, parameter.value(base) + step).geometry
        points = moved(mesh.points, base.geometry, changed)
        for axis in range(3):
            # planes of a half: y ≥ 0
            planes = np.unique(changed.solid().planes(axis).round(9))
            planes = planes[planes >= 0]
            assert np.isclose(points[:, axis][:, None], planes).any(axis=0).all(), parameter.key
        expected = check(structured_mesh(changed, SMALL))
        found = check(SolidMesh(points, mesh.cells, mesh.facets))
        assert found.volume_mm3 == pytest.approx(expected.volume_mm3, rel=1e-9), parameter.key
        assert found.cavity_mm3 == pytest.approx(expected.cavity_mm3, rel=1e-9), parameter.key


def test_another_number_of_chambers_is_refused() -> None:
    mesh = structured_mesh(Cast(), SMALL)
    with pytest.raises(MeshError, match=r"^cast\.chambers = 7: allowed: 5, the number in the mesh"):
        moved(mesh.points, Cast(), Cast(chambers=7))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (["finger.kind=kast"], 'finger.kind = "kast": allowed: bellows, cast, pneunet'),
        (["cast.wall_mm=3"], 'finger.kind = bellows: allowed: "cast" with a table [cast]'),
        (["finger.kind=cast", "finger.wall_mm=3"], "finger.wall_mm = 3.0: of bellows; allowed: "),
        (["finger.kind=cast", "cast.film_mm=0"], "cast.film_mm = 0: allowed: at least 0.01 "),
        (["finger.kind=cast", "cast.wall_mm=-7"], "cast.wall_mm = -7: allowed: at least 0.01 "),
        (
            ["finger.kind=cast", "cast.tunnel_width_mm=9"],
            "cast.tunnel_width_mm = 9.0: allowed: above 0 and up to chamber_width_mm = 8 mm",
        ),
        (
            ["finger.kind=cast", "cast.tunnel_height_mm=9"],
            "cast.tunnel_height_mm = 9.0: allowed: above 0 and up to chamber_height_mm = 8 mm",
        ),
        (
            ["finger.kind=cast", "cast.tunnel_height_mm=7.995"],
            "cast: leaves 0.005 mm between two faces at x = 8.495 mm; allowed: at least 0.01 mm",
        ),
        (["finger.kind=cast", "solver.element=P2"], "finger.kind = cast: made of hexahedra; "),
        (
            ["finger.kind=pneunet", "pneunet.chamber_width_mm=25"],
            "pneunet.chamber_width_mm = 25.0: wider than the block; allowed: above 0 and up to ",
        ),
        (
            ["finger.kind=pneunet", "pneunet.tunnel_height_mm=12"],
            "pneunet.tunnel_height_mm = 12.0: cavity not closed between chambers; allowed: ",
        ),
        (
            ["finger.kind=pneunet", "pneunet.tunnel_width_mm=17"],
            "pneunet.tunnel_width_mm = 17.0: wider than the chambers; allowed: above 0 and up to ",
        ),
        (
            ["finger.kind=cast", "plate.contact_length_mm=60"],
            "plate.contact_length_mm = 60.0: allowed: above 0 and up to cast.length_mm = 52 mm",
        ),
        (
            ["finger.kind=cast", "extensions.base_layer_offset.offset_mm=0.1"],
            "extensions.base_layer_offset.offset_mm = 0.1: allowed: with a finger that has a ",
        ),
    ],
)
def test_bad_geometry_is_one_clear_line(settings: list[str], said: str) -> None:
    with pytest.raises(ConfigError) as error:
        solid(config.load(overrides=assignments(settings)))
    assert str(error.value).startswith(said)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("suffix", [".msh", ".inp", ".vtk", ".vtu"])
@pytest.mark.parametrize("order", [1, 2])
def test_regions_are_written_and_read(suffix: str, order: int, tmp_path: Path) -> None:
    mesh = structured_mesh(Cast(chambers=2), SMALL.model_copy(update={"order": order}))
    files.write(tmp_path / f"cast{suffix}", mesh)
    again = files.read(tmp_path / f"cast{suffix}")
    assert set(again.regions) == {"body", "film"}
    middles = again.points[again.cells[:, :8]].mean(axis=1)[:, 0]
    inside = np.zeros(len(middles), dtype=bool)
    inside[again.regions["film"]] = True
    np.testing.assert_array_equal(inside, middles < 0.5)
    assert check(again).volume_mm3 == pytest.approx(check(mesh).volume_mm3, rel=1e-12)


def test_a_file_whose_regions_are_not_those_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "cast.msh"
    files.write(file, structured_mesh(Cast(chambers=2), SMALL))
    asked = config.load(None, assignments([f"mesh.file='{file}'", "material.silk.mu_MPa=3"]))
    said = 'material.silk = "silk": no such region; allowed: body, film'
    with pytest.raises(MeshError, match=re.escape(said)):
        load_domain(asked, MPI.COMM_SELF)
    found = config.load(None, assignments([f"mesh.file='{file}'", "material.film.mu_MPa=3"]))
    assert set(load_domain(found, MPI.COMM_SELF).parts) == {"film", "rest"}


def test_round_bellows_are_cylinders_in_closed_form() -> None:
    """Half of the actuator: volumes by hand, to the chords of a mesh's triangles."""
    shape = RoundBellows(convolutions=2, crown_radius_mm=6.0)
    mesh = finger_mesh(shape, Mesh(size_mm=1.5))
    found = check(mesh)
    hollow = 2 * (7.0 - 2.5 - 1.6) * np.pi * (5.2**2 - 2.2**2) + 14.0 * np.pi * 2.2**2
    outer = 2 * (7.0 - 2.5) * np.pi * (6.0**2 - 3.0**2) + 14.0 * np.pi * 3.0**2
    blocks = 2 * 5.0 * 12.0 * 26.0
    print(found.summary(), hollow, outer - hollow + blocks / 2)
    assert found.cavity_mm3 == pytest.approx(hollow, rel=0.05)  # half of each of the two
    assert found.volume_mm3 == pytest.approx(outer - hollow + blocks / 2, rel=0.03)
    centres = [mesh.points[mesh.facets[name]].reshape(-1, 3).mean(axis=0) for name in PAIR]
    assert [centre[0] for centre in centres] == pytest.approx([20.0, 6.0], abs=0.3)
    assert np.unique(mesh.points[mesh.facets["clamp"]][..., 2]) == pytest.approx([0.0])


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (("round_bellows.pitch_mm=4",), "round_bellows.pitch_mm = 4.0: leaves no cavity in a "),
        (("round_bellows.neck_radius_mm=0.8",), "round_bellows.neck_radius_mm = 0.8: closes "),
        (("round_bellows.crown_radius_mm=3",), "round_bellows.crown_radius_mm = 3.0: allowed: "),
        (("solver.element=S2",), "finger.kind = round_bellows: made of tetrahedra; allowed: "),
        (("cavity.cavity_3.pressure_ratio=0",), "cavity.cavity_3 = "),
    ],
)
def test_bad_round_bellows_are_one_clear_line(overrides: tuple[str, ...], said: str) -> None:
    with pytest.raises(ConfigError) as error:
        config.load(None, assignments(["finger.kind=round_bellows", *overrides]))
    assert str(error.value).startswith(said)
