"""Parts of other people's kinds: many cavities, held regions, several files, other formats."""

from __future__ import annotations

import math
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import gmsh
import numpy as np
import pytest
from support import hollow_bar

from dolfingrip.meshes import files, groups
from dolfingrip.meshes.adoption.adopt import ANOTHER_SIZE, AdoptedPart, adopt
from dolfingrip.meshes.adoption.formats import triangles_of
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


CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
TO_MODEL = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"


def of_slicer(objects: str, items: str) -> str:
    """A model as slicers write it, whose components may lie in other models of the archive."""
    return (
        f'<?xml version="1.0"?><model unit="millimeter" xmlns="{CORE}" xmlns:p="{PRODUCTION}" '
        f'requiredextensions="p"><resources>{objects}</resources><build>{items}</build></model>'
    )


@pytest.mark.parametrize("unit", ["millimeter", "centimeter"])
def test_3mf_of_a_slicer_whose_objects_are_models_of_their_own(tmp_path: Path, unit: str) -> None:
    """Numbers of objects are those of their model; placements lie in one another.

    Two plates: the bar of `hollow_bar` on the first one, and a box, 100 mm away, on the second one.
    """
    scale = {"millimeter": 1.0, "centimeter": 10.0}[unit]

    def mesh(points: np.ndarray, rows: np.ndarray, number: int) -> str:
        corners = "".join(
            f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in np.asarray(points) / scale
        )
        facets = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in rows)
        return (
            f'<object id="{number}" type="model"><mesh><vertices>{corners}</vertices>'
            f"<triangles>{facets}</triangles></mesh></object>"
        )

    points, rows = hollow_bar.triangles()
    box, sides = hollow_bar.box(np.zeros(3), np.array([4.0, 5.0, 6.0]))
    outer, inner = (of_slicer(each, "").replace("millimeter", unit) for each in (
        mesh(points[:8], rows[:12], 1) + mesh(points[8:], rows[12:] - 8, 2), mesh(box, sides, 1),
    ))  # fmt: skip
    quarter, beside = "0 1 0 -1 0 0 0 0 1 30 0 0", "1 0 0 0 1 0 0 0 1 100 0 0"
    main = of_slicer(
        '<object id="1"><components>'
        '<component p:path="/3D/Objects/bar_1.model" objectid="1"/>'
        '<component p:path="/3D/Objects/bar_1.model" objectid="2"/></components></object>'
        f'<object id="2"><components><component objectid="1" transform="{quarter}"/>'
        "</components></object>",
        f'<item objectid="2" transform="1 0 0 0 1 0 0 0 1 0 7 0"/>'
        f'<item objectid="1" p:path="/3D/Objects/box.model" transform="{beside}"/>',
    )
    told = (
        '<?xml version="1.0"?><Relationships '
        'xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
        f'<Relationship Target="/3D/3dmodel.model" Id="r" Type="{TO_MODEL}"/></Relationships>'
    )
    with zipfile.ZipFile(tmp_path / "part.3mf", "w") as packed:
        packed.writestr("3D/Objects/bar_1.model", outer)
        packed.writestr("3D/Objects/box.model", inner)
        packed.writestr("_rels/.rels", told)
        packed.writestr("3D/3dmodel.model", main)
    found, triangles = triangles_of(tmp_path / "part.3mf", 1.0)
    assert len(triangles) == 36
    expected = np.vstack(
        [points @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]] + [30, 7, 0], box + np.array([100, 0, 0])]
    )
    for place in expected:
        assert np.abs(found - place).max(axis=1).min() < 1e-5
    volume = enclosed_volume(found, triangles)
    assert volume == pytest.approx(hollow_bar.VOLUME_MM3 + 120.0, rel=1e-5)
    with zipfile.ZipFile(tmp_path / "lost.3mf", "w") as packed:
        packed.writestr("3D/3dmodel.model", main)
    with pytest.raises(MeshError, match=r"no object 1 in /3D/Objects/bar_1\.model; allowed"):
        triangles_of(tmp_path / "lost.3mf", 1.0)


def text_stl(name: str, end: str) -> bytes:
    """The bar as a text."""
    points, rows = hollow_bar.triangles()
    facets = (
        "facet normal 0 0 0\n  outer loop\n"
        + "".join(f"    vertex {x:.3e} {y:+g} {z}\n" for x, y, z in points[row])
        + "  endloop\nendfacet\n"
        for row in rows
    )
    return f"solid {name}\n{''.join(facets)}{end}".encode()


BEHIND = b"//+\r\nSurface Loop(1) = {1};\r\n//+\r\nVolume(1) = {1};\r\n"
TEXTS = {
    "text": text_stl("bar", "endsolid bar\n"),
    "text and more": text_stl("bar", "endsolid bar\n") + BEHIND,
    "text without end": text_stl("bar", ""),
    "upper case": text_stl("bar", "endsolid bar\n").upper(),
    "byte order mark": b"\xef\xbb\xbf" + text_stl("", "endsolid\n"),
}


@pytest.mark.parametrize("header", [b"bar", b"solid bar of a CAD program", b"solid\nfacet normal"])
@pytest.mark.parametrize("behind", [b"", BEHIND], ids=["alone", "text behind"])
def test_binary_stl(tmp_path: Path, header: bytes, behind: bytes) -> None:
    """Whose header may begin as a text's does; what follows the last triangle is no triangle."""
    points, triangles = triangles_of(hollow_bar.stl(tmp_path / "bar.stl", header, behind), 1.0)
    assert (len(points), len(triangles)) == (16, 24)
    assert enclosed_volume(points, triangles) == pytest.approx(hollow_bar.VOLUME_MM3, rel=1e-6)


@pytest.mark.parametrize("content", TEXTS.values(), ids=list(TEXTS))
def test_text_stl(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "bar.STL").write_bytes(content)
    points, triangles = triangles_of(tmp_path / "bar.STL", 1.0)
    assert enclosed_volume(points, triangles) == pytest.approx(hollow_bar.VOLUME_MM3, rel=1e-6)


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj", ".vtk", ".vtu"])
@pytest.mark.parametrize("content", [
    b"", b"solid bar\n", b"nothing of the kind\n", b"solid\nvertex 1 2 3\n", b"solid\nvertex 1 2 e",
    TEXTS["text"].replace(b".", b","), b"ply\nformat ascii 1.0\nelement vertex 3\n",
])  # fmt: skip
def test_what_has_no_triangles_gets_one_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], suffix: str, content: bytes
) -> None:
    """And nothing of what VTK has to say of it."""
    (tmp_path / f"bar{suffix}").write_bytes(content)
    with warnings.catch_warnings(record=True) as warned, pytest.raises(MeshError) as caught:
        triangles_of(tmp_path / f"bar{suffix}", 1.0)
    assert not warned
    assert "\n" not in str(caught.value)
    assert "allowed: " in str(caught.value) or "XML" in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_a_binary_stl_that_ends_early(tmp_path: Path) -> None:
    whole = hollow_bar.stl(tmp_path / "bar.stl").read_bytes()
    (tmp_path / "bar.stl").write_bytes(whole[:700])
    with pytest.raises(MeshError, match="no triangles; allowed: a closed surface of triangles"):
        triangles_of(tmp_path / "bar.stl", 1.0)
