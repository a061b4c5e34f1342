"""Parts of other people's kinds: many cavities, held regions, several files, other formats."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import gmsh
import numpy as np
import pytest

from dolfingrip.meshes import files, groups
from dolfingrip.meshes.adoption.adopt import ANOTHER_SIZE, AdoptedPart, adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.measures import enclosed_volume
from dolfingrip.meshes.quality import check, judge
from dolfingrip.meshes.solid import MeshError, SolidMesh, boundary, faces

PARTS = Path(__file__).with_name("parts")
HELD = (-20.0, -20.0, -20.0, 20.0, 20.0, 0.0)
AIR_MM3 = math.pi * 1.5**2


def drawn(file: Path, *names: str) -> Path:
    """A file with some of: a bar along z on a collar from z = −12 to 0, cavity, air, in mm.

    The air's bore leads from the cavity down through the collar. What comes after "-" is cut off.
    """
    occ = gmsh.model.occ
    make: dict[str, Callable[[], int]] = {
        "bar": lambda: occ.addBox(-9, -8, 0, 18, 16, 40),
        "collar": lambda: occ.addCylinder(0, 0, -12, 0, 0, 12, 14),
        "cavity": lambda: occ.addBox(-3.5, -5, 3, 10, 10, 34),
        "air": lambda: occ.addCylinder(1.5, 0, -12, 0, 0, 16, 1.5),
    }
    with session("part"):
        made = [(3, make[name]()) for name in names if name != "-"]
        cut = names.index("-") if "-" in names else len(names)
        solid = made[:1] if cut == 1 else occ.fuse(made[:1], made[1:cut])[0]
        if made[cut:]:
            occ.cut(solid, made[cut:])
        occ.synchronize()
        if file.suffix == ".stl":
            gmsh.option.setNumber("Mesh.MeshSizeMax", 8)
            gmsh.model.mesh.generate(2)
        gmsh.write(str(file))
    return file


def in_file(part: AdoptedPart, facets: dict[str, np.ndarray]) -> SolidMesh:
    """The part's mesh where its file has it, with these groups."""
    points = part.mesh.points @ part.roles.rotation + part.roles.origin_mm
    return replace(part.mesh, points=points, facets=facets)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> AdoptedPart:
    """Bar and collar with cavity and air, meshed as they are."""
    file = drawn(tmp_path_factory.mktemp("whole") / "whole.step", "bar", "collar", "-", "cavity",
                 "air")  # fmt: skip
    return adopt(file, Asked(whole=True), MeshRequest(size_mm=4))


@pytest.fixture(scope="module")
def worm(tmp_path_factory: pytest.TempPathFactory) -> AdoptedPart:
    """A bar of 7 × 8 × 75 mm with twelve closed chambers of 4 × 4 × 4 mm."""
    file, occ = tmp_path_factory.mktemp("worm") / "worm.step", gmsh.model.occ
    with session("worm"):
        chambers = [(3, occ.addBox(1.5, -2, 2 + 6 * i, 4, 4, 4)) for i in range(12)]
        occ.cut([(3, occ.addBox(0, -4, 0, 7, 8, 74))], chambers)
        occ.synchronize()
        gmsh.write(str(file))
    return adopt(file, Asked(), MeshRequest())


def test_twelve_cavities_from_the_clamp_on(worm: AdoptedPart) -> None:
    names = groups.cavities(worm.mesh.facets)
    assert names == groups.cavity_names(12)
    for i, name in enumerate(names):
        found = -2 * enclosed_volume(worm.mesh.points, worm.mesh.facets[name])
        assert found == pytest.approx(64, rel=1e-9)  # plane faces, so exactly
        assert worm.mesh.points[worm.mesh.facets[name], 2].min() == pytest.approx(2 + 6 * i)


@pytest.mark.parametrize("suffix", [".msh", ".inp", ".vtu"])
def test_twelve_cavities_in_a_file(worm: AdoptedPart, tmp_path: Path, suffix: str) -> None:
    files.write(tmp_path / f"worm{suffix}", worm.mesh)
    again = files.read(tmp_path / f"worm{suffix}")
    assert {name: len(found) for name, found in again.facets.items()} == {
        name: len(found) for name, found in worm.mesh.facets.items()
    }


def test_a_collar_that_is_held_in_a_box(tmp_path: Path, whole: AdoptedPart) -> None:
    """What it holds is left out: the body is the same as one that ends where the collar does."""
    collar = drawn(tmp_path / "collar.step", "bar", "collar", "-", "cavity", "air")
    plane = drawn(tmp_path / "plane.step", "bar", "-", "cavity", "air")
    held = adopt(collar, Asked(held=[HELD]), MeshRequest())
    bare = adopt(plane, Asked(), MeshRequest())
    assert (held.quality.cells, held.quality.points) == (bare.quality.cells, bare.quality.points)
    assert held.quality.volume_mm3 == pytest.approx(bare.quality.volume_mm3, rel=1e-9)
    assert np.allclose(held.roles.rotation, bare.roles.rotation)
    assert "where what --clamp-region holds ends, at (-0.04, 0, 0) mm" in held.roles.said["clamp"]
    assert 2 * held.quality.cavity_mm3 == pytest.approx(3400 + 3 * AIR_MM3, rel=1e-3)


def test_a_collar_that_a_group_of_facets_surrounds(tmp_path: Path, whole: AdoptedPart) -> None:
    """Its outer faces hold what a box around it holds; a group in a plane surrounds nothing."""
    mesh = in_file(whole, {})
    outer = faces(mesh.cells)[boundary(mesh.cells)]
    z = mesh.points[outer, 2]
    seen = ~np.isin(outer, np.unique(whole.mesh.facets["cavity"])).any(axis=1)
    ends = {"clamp": outer[seen & (z.max(axis=1) < 1e-6)], "tip": outer[z.min(axis=1) > 40 - 1e-6]}
    files.write(tmp_path / "collar.msh", replace(mesh, facets=ends))
    box, ring = (
        adopt(tmp_path / "collar.msh", Asked(held=[each]), MeshRequest())
        for each in (HELD, "clamp")
    )
    np.testing.assert_array_equal(ring.mesh.cells, box.mesh.cells)
    np.testing.assert_allclose(ring.mesh.points, box.mesh.points)
    assert len(ring.mesh.cells) < 0.9 * len(mesh.cells)
    with pytest.raises(MeshError, match="--clamp-region tip: holds nothing"):
        adopt(tmp_path / "collar.msh", Asked(held=["tip"]), MeshRequest())
    with pytest.raises(MeshError, match=r"cork: no such region; allowed: .*clamp"):
        adopt(tmp_path / "collar.msh", Asked(held=["cork"]), MeshRequest())


def test_a_named_solid_that_is_held(tmp_path: Path) -> None:
    """A plug in the open end of a bar: the cavity ends at its plane face."""
    file, occ = tmp_path / "plug.step", gmsh.model.occ
    with session("plug"):
        bar = occ.cut(
            [(3, occ.addBox(-9, -8, 0, 18, 16, 40))], [(3, occ.addBox(-5, -5, -1, 11, 10, 38))]
        )
        plug = occ.addBox(-5, -5, 0, 11, 10, 6)
        occ.fragment(bar[0], [(3, plug)])
        occ.synchronize()
        gmsh.write(str(file))
    found = adopt(file, Asked(held=["part_2"]), MeshRequest())
    assert 2 * found.quality.cavity_mm3 == pytest.approx(11 * 10 * 31)
    assert set(found.mesh.facets) >= {"cavity", "clamp", "skin", "tip"}
    with pytest.raises(
        MeshError, match=r"--clamp-region cork: no such solid; allowed: part_1, part_2"
    ):
        adopt(file, Asked(held=["cork"]), MeshRequest())


@pytest.mark.parametrize("how", ["box", "region", "group"])
def test_a_held_collar_of_a_mesh(tmp_path: Path, whole: AdoptedPart, how: str) -> None:
    """Without groups, in a box or a region; or with a group, the collar's outside."""
    mesh = in_file(whole, {})
    outer = np.concatenate([whole.mesh.facets[name] for name in ("skin", "clamp", "tip")])
    low = mesh.points[outer[:, :3], 2].max(axis=1) < 1e-6
    volume, held = 3400 + 3 * AIR_MM3, [HELD]
    if how == "region":
        rows = np.flatnonzero(mesh.points[mesh.cells[:, :4], 2].max(axis=1) < 1e-6)
        mesh, held = replace(mesh, regions={"collar": rows}), ["collar"]
    if how == "group":
        mesh, held = replace(mesh, facets={"clamp": outer[low]}), []
        volume += 12 * AIR_MM3  # the bore through the collar is the cavity's, too
    files.write(tmp_path / "part.msh", mesh)
    found = adopt(tmp_path / "part.msh", Asked(held=held), MeshRequest())
    assert np.allclose(found.roles.rotation, whole.roles.rotation, atol=1e-9)
    assert found.quality.cavity_mm3 == pytest.approx(volume, rel=5e-3)
    assert found.mesh.points[:, 2].max() == pytest.approx(40)
    # wherever the origin is, the opening at the held rim closes the cavity
    moved = replace(found.mesh, points=found.mesh.points + np.array([3.0, 2.0, 7.0]))
    assert check(moved).cavity_mm3 == pytest.approx(found.quality.cavity_mm3, rel=1e-9)


def test_an_opening_that_is_not_held_is_refused(whole: AdoptedPart) -> None:
    mesh = whole.mesh
    roles = whole.roles
    bore = roles.rotation @ (roles.cavities[0].openings[0].centre_mm - roles.origin_mm)
    rim = np.linalg.norm(mesh.points[mesh.facets["clamp"]] - bore, axis=2).min(axis=1) < 1.6
    facets = {
        **mesh.facets,
        "clamp": mesh.facets["clamp"][~rim],
        "skin": np.concatenate([mesh.facets["skin"], mesh.facets["clamp"][rim]]),
    }
    with pytest.raises(MeshError, match=r"group cavity: not closed, \d+ edges with one facet"):
        check(replace(mesh, facets=facets))


@pytest.mark.parametrize("suffix", [".step", ".stl"])
def test_body_and_cavity_in_two_files(tmp_path: Path, suffix: str) -> None:
    body = drawn(tmp_path / f"body{suffix}", "bar")
    cavity = drawn(tmp_path / f"cavity{suffix}", "cavity")
    one = adopt(drawn(tmp_path / f"one{suffix}", "bar", "-", "cavity"), Asked(), MeshRequest())
    two = adopt(body, Asked(cavity_files=[cavity]), MeshRequest())
    assert 2 * two.quality.cavity_mm3 == pytest.approx(3400, rel=1e-9)
    assert two.quality.volume_mm3 == pytest.approx(one.quality.volume_mm3, rel=1e-9)
    assert two.roles.said["back"] == one.roles.said["back"]
    away = drawn(tmp_path / f"away{suffix}", "collar")
    with pytest.raises(MeshError, match=r"--cavity|no cavity"):
        adopt(body, Asked(cavity_files=[away]), MeshRequest())


@pytest.mark.parametrize("suffix", [".step", ".stl"])
def test_a_volume_mesh_and_the_walls_of_its_cavity(
    tmp_path: Path, whole: AdoptedPart, suffix: str
) -> None:
    """As SOFA keeps them: the walls' triangles are not the mesh's, and say where its cavity is."""
    closed = adopt(
        drawn(tmp_path / "one.step", "bar", "-", "cavity"), Asked(whole=True), MeshRequest()
    )
    files.write(tmp_path / "body.vtk", in_file(closed, {}))
    cavity = drawn(tmp_path / f"cavity{suffix}", "cavity")
    found = adopt(tmp_path / "body.vtk", Asked(cavity_files=[cavity]), MeshRequest())
    assert found.quality.cavity_mm3 == pytest.approx(3400, rel=1e-9)
    assert len(found.mesh.facets["cavity"]) == len(closed.mesh.facets["cavity"])


def test_3mf_with_units_and_transforms(tmp_path: Path) -> None:
    """A box of 1 × 2 × 3 inches with a hollow, a component turned by 90° and moved."""
    corners = np.argwhere(np.ones((2, 2, 2)))
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    rows = [(a, b, c) for a, b, c, _ in sides] + [(a, c, d) for a, _, c, d in sides]

    def mesh(size: tuple[float, ...]) -> str:
        points = corners * size
        return (
            "<mesh><vertices>"
            + "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in points)
            + "</vertices><triangles>"
            + "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in rows)
            + "</triangles></mesh>"
        )

    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    model = (
        f'<model unit="inch" xmlns="{core}"><resources>'
        f'<object id="1">{mesh((1, 2, 3))}</object><object id="2">{mesh((0.5, 1, 2))}</object>'
        '<object id="3"><components><component objectid="1"/>'
        '<component objectid="2" transform="1 0 0 0 1 0 0 0 1 0.25 0.5 0.5"/></components></object>'
        '</resources><build><item objectid="3" transform="0 1 0 -1 0 0 0 0 1 5 0 0"/></build>'
        "</model>"
    )
    with zipfile.ZipFile(tmp_path / "part.3mf", "w") as packed:
        packed.writestr("3D/3dmodel.model", model)
    found = adopt(tmp_path / "part.3mf", Asked(whole=True), MeshRequest())
    assert found.quality.cavity_mm3 == pytest.approx(1.0 * 25.4**3)
    assert found.quality.volume_mm3 == pytest.approx(5.0 * 25.4**3)
    assert sorted(found.size_mm) == pytest.approx([25.4, 50.8, 76.2])


def test_a_leaky_surface_is_repaired(tmp_path: Path) -> None:
    import pyvista as pv

    file = drawn(tmp_path / "one.stl", "bar", "-", "cavity")
    surface = pv.read(file)
    surface.extract_cells(np.arange(1, surface.n_cells)).extract_surface(
        algorithm="dataset_surface"
    ).save(file)
    with pytest.raises(MeshError, match=r"not watertight: a hole .* a closed surface, or --repair"):
        adopt(file, Asked(), MeshRequest())
    pytest.importorskip("pymeshfix", reason="the extra repair brings it")
    found = adopt(file, Asked(repair=True, whole=True), MeshRequest())
    assert found.quality.cavity_mm3 == pytest.approx(3400, rel=1e-6)


def test_quality_is_judged(worm: AdoptedPart) -> None:
    """A node that moves towards the opposite face makes its element flat."""
    mesh = worm.mesh
    inner = np.setdiff1d(mesh.cells, np.concatenate([f.ravel() for f in mesh.facets.values()]))
    assert judge(mesh, worm.quality, ANOTHER_SIZE) == worm.warnings
    cell = mesh.cells[np.isin(mesh.cells, inner).any(axis=1)][0]
    node = cell[np.isin(cell, inner)][0]
    face = mesh.points[cell[cell != node]].mean(axis=0)
    told = []
    for share in (1e-2, 1e-6):
        points = mesh.points.copy()
        points[node] = face + share * (points[node] - face)
        flat = replace(mesh, points=points)
        try:
            quality = replace(worm.quality, scaled_jacobian_min=share)
            told.append(" ".join(judge(flat, quality, "mesh it anew")))
        except MeshError as error:
            told.append(str(error))
    assert "elements have a scaled Jacobian below 0.02, 0.01 at least" in told[0]
    assert told[1].startswith("mesh: least scaled Jacobian 1e-06; allowed: from 0.0001 on; mesh it")


def test_one_element_through_the_wall(tmp_path: Path) -> None:
    file = drawn(tmp_path / "one.step", "bar", "-", "cavity")
    coarse, fine = (adopt(file, Asked(), MeshRequest(size_mm=size)) for size in (4.0, 1.3))
    assert "one element through the wall at" in " ".join(coarse.warnings)
    assert fine.warnings == ()
