"""Parts from files: what is taken for what, checked against shapes whose volumes are known."""

from __future__ import annotations

import math
from pathlib import Path

import gmsh
import numpy as np
import pytest

from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.solid import MeshError, faces, on_plane


def tube(file: Path, *, closed: bool = False) -> Path:
    """A round tube along x, 60 mm long, of radii 10 and 7 mm, with an end of 5 mm; as STEP."""
    occ = gmsh.model.occ
    with session("tube"):
        outer = occ.addCylinder(0, 0, 0, 60, 0, 0, 10)
        start = 5.0 if closed else -1.0
        inner = occ.addCylinder(start, 0, 0, 55 - start, 0, 0, 7)
        occ.cut([(3, outer)], [(3, inner)])
        occ.synchronize()
        gmsh.write(str(file))
    return file


@pytest.mark.parametrize("closed", [True, False])
def test_the_volumes_of_a_tube(tmp_path: Path, closed: bool) -> None:
    found = adopt(tube(tmp_path / "tube.step", closed=closed), Asked(), MeshRequest())
    hollow = math.pi * 7**2 * (50 if closed else 55)
    assert found.roles.half
    assert 2 * found.quality.cavity_mm3 == pytest.approx(hollow, rel=5e-3)
    assert 2 * found.quality.volume_mm3 == pytest.approx(math.pi * 6000 - hollow, rel=5e-3)
    assert found.size_mm == pytest.approx([20, 20, 60], rel=1e-2)


def test_a_wall_too_thin_for_its_mesh(tmp_path: Path) -> None:
    file = tube(tmp_path / "tube.step")
    with pytest.raises(MeshError, match=r"--size-mm 9: too large for a wall of 2\.\d+ mm") as error:
        adopt(file, Asked(), MeshRequest(size_mm=9.0))
    most = float(str(error.value).split()[-2])
    assert adopt(file, Asked(), MeshRequest(size_mm=most)).measured.size_mm == most


def test_a_file_that_is_no_part(tmp_path: Path) -> None:
    file = tmp_path / "part.step"
    file.write_text("nothing", encoding="utf-8")
    with pytest.raises(MeshError, match=r"part\.step: not readable"):
        adopt(file, Asked(), MeshRequest())


def bent_tube(file: Path) -> Path:
    """A sixth of a torus around a circle of 60 mm, of radii 9 and 6 mm, open at both ends."""
    occ = gmsh.model.occ
    with session("bent tube"):
        outer, inner = (occ.addTorus(60, 0, 0, 60, r, -1, math.pi / 3) for r in (9, 6))
        occ.cut([(3, outer)], [(3, inner)])
        occ.synchronize()
        gmsh.write(str(file))
    return file


def test_a_cap_in_a_hollow_that_turns(tmp_path: Path) -> None:
    found = adopt(bent_tube(tmp_path / "bent.step"), Asked(), MeshRequest())
    outer = math.pi * 9**2 * 60 * math.pi / 3  # Pappus
    sides = 2 if found.roles.half else 1
    assert len(found.roles.caps) == 1
    everything = sides * (found.quality.volume_mm3 + found.quality.cavity_mm3)
    assert everything == pytest.approx(outer, rel=5e-3)
    hollow = outer * 6**2 / 9**2 - math.pi * 6**2 * found.measured.cap_mm
    assert sides * found.quality.cavity_mm3 == pytest.approx(hollow, rel=1e-2)


def triangles(file: Path, deg: float = 15.0) -> Path:
    """The surface of a STEP file as STL, with a facet for so many degrees."""
    with session("triangles"):
        gmsh.model.occ.importShapes(str(file))
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 360 / deg)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 30)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(file.with_suffix(".stl")))
    return file.with_suffix(".stl")


def test_triangles_with_an_opening_away_from_the_clamp(tmp_path: Path) -> None:
    file = triangles(bent_tube(tmp_path / "bent.step"))
    found = adopt(file, Asked(), MeshRequest())
    assert found.roles.caps == []
    outer, inner = (math.pi * r**2 * 60 * math.pi / 3 for r in (9, 6))
    everything = found.quality.volume_mm3 + found.quality.cavity_mm3
    assert everything == pytest.approx(outer, rel=0.03)  # a polygon of 24 sides has 1.1 % less
    hollow = inner - math.pi * 6**2 * found.measured.cap_mm
    assert found.quality.cavity_mm3 == pytest.approx(hollow, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".step", ".stl"])
def test_an_opening_in_a_curved_face(tmp_path: Path, suffix: str) -> None:
    """A closed hollow with a hole of radius 2 mm through the round side, where the wall is thin."""
    file, occ = tmp_path / "port.step", gmsh.model.occ
    with session("port"):
        body = occ.addCylinder(0, 0, 0, 0, 0, 50, 10)
        tools = [
            (3, occ.addCylinder(0, 0, 4, 0, 0, 42, 7)),
            (3, occ.addCylinder(0, 0, 30, 15, 0, 0, 2)),
        ]
        occ.cut([(3, body)], tools)
        occ.synchronize()
        gmsh.write(str(file))
    part = file if suffix == ".step" else triangles(file)
    found = adopt(part, Asked(), MeshRequest(size_mm=2.5))
    sides = 2 if found.roles.half else 1
    assert "closes 1 opening" in found.roles.said["cap"]
    hollow = math.pi * 7**2 * 42
    assert sides * found.quality.cavity_mm3 == pytest.approx(hollow, rel=0.03)
    assert hollow + math.pi * 2**2 * 3 > sides * found.quality.cavity_mm3


def test_a_tube_of_thin_walls_is_its_own_mirror_image(tmp_path: Path) -> None:
    """Its inner triangles are nearer to the outer ones than to their own images' centres."""
    occ, file = gmsh.model.occ, tmp_path / "thin.step"
    with session("thin"):
        tool = occ.addBox(0.3, 0.3, -1, 5.4, 5.4, 9.7)
        occ.cut([(3, occ.addBox(0, 0, 0, 6, 6, 9))], [(3, tool)])
        occ.synchronize()
        gmsh.write(str(file))
    told: list[str] = []
    found = adopt(file, Asked(), MeshRequest(tell=told.append))
    assert found.roles.half
    assert len(told) == 1
    assert "the thinnest wall has 0.3 mm" in told[0]


def test_two_cavities_without_slivers(tmp_path: Path) -> None:
    occ = gmsh.model.occ
    with session("two cavities"):
        body = occ.addBox(0, 0, 0, 20, 30, 80)
        tools = [(3, occ.addBox(3, y, -1, 14, 10.5, 76)) for y in (3, 16.5)]
        occ.cut([(3, body)], tools)
        occ.synchronize()
        gmsh.write(str(tmp_path / "two.step"))
    found = adopt(tmp_path / "two.step", Asked(whole=True), MeshRequest())
    assert {"cavity", "cavity_2"} <= set(found.mesh.facets)
    assert found.quality.cavity_mm3 == pytest.approx(2 * 14 * 10.5 * 75)
    # scaled Jacobian 0.018 with the first size that is tried
    assert found.quality.scaled_jacobian_min > 0.05


def test_four_round_cavities_without_slivers(tmp_path: Path) -> None:
    """Delaunay's fill has scaled Jacobians from 5e-5 to 0.006 with each size; HXT's none."""
    occ = gmsh.model.occ
    with session("four cavities"):
        tools = []
        for x in (-20, 1):
            for y in (-20, 1):
                round_one = [(3, occ.addCylinder(0, 0, 4, 0, 0, 72, 20))]
                tools += occ.intersect(round_one, [(3, occ.addBox(x, y, 4, 19, 19, 72))])[0]
        occ.cut([(3, occ.addCylinder(0, 0, 0, 0, 0, 80, 22))], tools)
        occ.synchronize()
        gmsh.write(str(tmp_path / "four.step"))
    found = adopt(tmp_path / "four.step", Asked(clamp=(0, 0, 0)), MeshRequest())
    assert found.quality.scaled_jacobian_min > 0.05
    assert not found.warnings


@pytest.mark.parametrize(
    ("boxes", "drop", "said"),
    [
        ([(0, 20, 0, 20, 0, 60)], 1, "not watertight: a hole with an edge of"),
        ([(0, 20, 0, 20, 0, 60), (5, 15, 5, 15, 5, 70)], 0, "intersects itself near (10, 10, "),
        ([(0, 20, 0, 20, 0, 60), (30, 40, 5, 15, 5, 70)], 0, "falls into 2 parts; allowed: one"),
    ],
)
def test_surfaces_that_enclose_no_solid(
    tmp_path: Path, boxes: list[tuple[float, ...]], drop: int, said: str
) -> None:
    import pyvista as pv

    parts = [pv.Box(box).triangulate() for box in boxes]
    starts = np.cumsum([0, *(part.n_points for part in parts)])
    points = np.concatenate([part.points for part in parts])
    faces = np.concatenate(
        [part.regular_faces + i for part, i in zip(parts, starts[:-1], strict=True)]
    )
    file = tmp_path / "part.stl"
    pv.PolyData.from_regular_faces(points, faces[drop:]).save(file)
    with pytest.raises(MeshError) as error:
        adopt(file, Asked(), MeshRequest())
    assert f"{file}: {said}" in str(error.value)


@pytest.mark.parametrize("suffix", [".step", ".stl"])
def test_the_side_of_the_cavity_is_told_by_its_lever_wherever_the_part_lies(
    suffix: str, tmp_path: Path
) -> None:
    """A bar with a box inside that lies 1 mm off its axis, far from the file's origin.

    The cavity's centre is A / (A − a) times as far from the centroid of the walls' section as from
    the bar's axis, A and a being the sections of bar and box.
    """
    file, occ = tmp_path / f"bar{suffix}", gmsh.model.occ
    with session("bar"):
        body = occ.addBox(200, -150, 90, 14, 14, 50)
        hollow = occ.addBox(204, -147, 94, 8, 8, 42)
        occ.cut([(3, body)], [(3, hollow)])
        occ.synchronize()
        if suffix == ".stl":
            gmsh.model.mesh.generate(2)
        gmsh.write(str(file))
    found = adopt(file, Asked(), MeshRequest())
    lever = 14 * 14 / (14 * 14 - 8 * 8)
    assert f"about the walls that run through is {lever:.2g} mm" in found.roles.said["back"]
    assert found.roles.origin_mm[1] == pytest.approx(-150 + 14 / 2)  # the plane of symmetry


TURNS = {
    "along x": (90.0, 0.0, 1.0, 0.0),
    "along −z": (180.0, 1.0, 0.0, 0.0),
    "5° about its axis": (5.0, 0.0, 0.0, 1.0),
    "45° in space": (45.0, 1.0, 1.0, 1.0),
    "45° in space, in m": (45.0, 1.0, 1.0, 1.0),
}


def test_a_mesh_is_the_same_finger_wherever_it_lies(tmp_path: Path) -> None:
    """Nodes in the finger's frame, and the faces that a film on the back covers.

    The elements are not symmetric, so that sums over their faces do not tell a side.
    """
    from scipy.spatial.transform import Rotation

    occ, files = gmsh.model.occ, {}
    with session("bar"):
        body = occ.addBox(0, -8, 0, 14, 16, 60)
        hollow = occ.addBox(4, -5, 0, 7.5, 10, 55)
        occ.cut([(3, body)], [(3, hollow)])
        occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 6)
        gmsh.model.mesh.generate(3)
        gmsh.option.setNumber("Mesh.SaveAll", 1)
        gmsh.write(str(tmp_path / "as_drawn.msh"))
        nodes, places, _ = gmsh.model.mesh.getNodes()
        for number, (name, (angle, *axis)) in enumerate(TURNS.items()):
            turn = Rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis), degrees=True)
            moved = turn.apply(places.reshape(-1, 3)) + np.array([100.0, -250.0, 33.0])
            for node, place in zip(nodes, moved / (1000 if "in m" in name else 1), strict=True):
                gmsh.model.mesh.setNode(node, place, [])
            files[name] = tmp_path / f"{number}.msh"
            gmsh.write(str(files[name]))
    drawn = adopt(tmp_path / "as_drawn.msh", Asked(), MeshRequest()).mesh
    back = on_plane(drawn, np.arange(len(drawn.cells)), highest=False)
    corners = drawn.points[faces(drawn.cells)[back]]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.linalg.norm(across, axis=1).sum() / 2 == pytest.approx(16 * 60)
    for name, file in files.items():
        found = adopt(file, Asked(), MeshRequest(), 1000.0 if "in m" in name else 1.0).mesh
        assert np.abs(found.points - drawn.points).max() < 2e-6, name
        assert (found.cells == drawn.cells).all()
        for group, facets in drawn.facets.items():
            assert (found.facets[group] == facets).all(), (name, group)
        assert (on_plane(found, np.arange(len(found.cells)), highest=False) == back).all(), name


def test_triangles_of_single_precision_that_are_turned_have_the_same_elements(
    tmp_path: Path,
) -> None:
    """Points every 0.5 mm along straight edges that rounding bends are no corners of the mesh."""
    import pyvista as pv

    drawn, least = pv.Box((0, 14, -8, 8, 0, 50), level=31, quads=False), []
    hollow = pv.Box((4, 11, -5, 5, 4, 46), level=15, quads=False)
    part = pv.merge([drawn, hollow]).extract_surface(algorithm="dataset_surface")
    for angle, move in ((0.0, 0.0), (45.0, 300.0)):
        part.rotate_z(angle).translate((move, -move, move)).save(tmp_path / "part.stl")
        found = adopt(tmp_path / "part.stl", Asked(), MeshRequest())
        assert found.quality.cavity_mm3 == pytest.approx(7 * 10 * 42 / 2, rel=1e-4)
        least.append(found.quality.edge_min_mm)
    assert least[1] == pytest.approx(least[0], rel=0.2)
    assert least[1] > 1.0


def test_a_back_by_rounded_numbers_is_the_plane_that_they_mean(tmp_path: Path) -> None:
    """The line `back` tells three decimals."""
    file = tmp_path / "bar.step"
    with session("bar"):
        occ = gmsh.model.occ
        bar = occ.addBox(0, -8, 0, 14, 16, 50)
        occ.cut([(3, bar)], [(3, occ.addBox(4, -5, 0, 7, 10, 45))])
        occ.rotate(occ.getEntities(3), 0, 0, 0, 0, 0, 1, math.radians(37))
        occ.synchronize()
        gmsh.write(str(file))
    exact = [-math.cos(math.radians(37)), -math.sin(math.radians(37)), 0.0]
    for back in (None, tuple(round(each, 3) for each in exact)):
        found = adopt(file, Asked(back=back), MeshRequest(size_mm=6.0))
        assert -found.roles.rotation[0] == pytest.approx(exact, abs=1e-9)
        assert found.roles.half
