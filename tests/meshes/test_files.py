"""Round trips, files of others, and what is refused."""

from __future__ import annotations

from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest

from dolfingrip.config import Finger
from dolfingrip.files.whole import WriteError
from dolfingrip.meshes import solid_model
from dolfingrip.meshes.cells import BY_NODES, HEXAHEDRON, TETRAHEDRON
from dolfingrip.meshes.files import read, write
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.groups import SOLID_TAG, SURFACE_TAGS
from dolfingrip.meshes.measures import jacobians
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh

MESHES = ["half", "half_second_order", "whole", "bricks", "bricks_second_order"]
NAMES = {
    4: ("tetra", "triangle"),
    10: ("tetra10", "triangle6"),
    8: ("hexahedron", "quad"),
    20: ("hexahedron20", "quad8"),
}
"""meshio's names of elements and facets, by an element's nodes."""
VTK_EDGES = {
    4: np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]),
    8: np.array(
        [
            *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)),
            *((0, 4), (1, 5), (2, 6), (3, 7)),
        ]
    ),
}
"""Ends of the edges in the order of their nodes, from VTK's file formats and Abaqus' manual."""


@pytest.fixture(params=MESHES)
def mesh(request: pytest.FixtureRequest) -> SolidMesh:
    found = request.getfixturevalue(request.param)
    assert isinstance(found, SolidMesh)
    return found


def same(mesh: SolidMesh, other: SolidMesh) -> None:
    assert np.abs(mesh.points - other.points).max() < 1e-12
    assert np.array_equal(mesh.cells, other.cells)
    assert set(mesh.facets) == set(other.facets)
    for name, facets in mesh.facets.items():
        assert {tuple(f) for f in facets.tolist()} == {
            tuple(f) for f in other.facets[name].tolist()
        }
    assert check(mesh).summary() == check(other).summary()


@pytest.mark.parametrize("suffix", [".msh", ".inp", ".INP"])
def test_round_trip(mesh: SolidMesh, suffix: str, tmp_path: Path) -> None:
    write(tmp_path / f"finger{suffix}", mesh)
    same(read(tmp_path / f"finger{suffix}"), mesh)
    assert [path.name for path in tmp_path.iterdir()] == [f"finger{suffix}"]


@pytest.mark.parametrize("suffix", [".vtk", ".vtu", ".msh", ".inp"])
def test_others_read_what_is_written(mesh: SolidMesh, suffix: str, tmp_path: Path) -> None:
    write(tmp_path / f"finger{suffix}", mesh)
    other = meshio.read(tmp_path / f"finger{suffix}")
    solid, facet = NAMES[mesh.cells.shape[1]]
    cells = other.cells_dict[solid]
    assert np.abs(other.points - mesh.points).max() < 1e-12
    assert np.array_equal(np.sort(cells), np.sort(mesh.cells))
    corners = mesh.shape.corners
    assert np.array_equal(cells[:, :corners], mesh.cells[:, :corners])
    if mesh.order == 2:
        middles = mesh.points[cells[:, VTK_EDGES[corners]]].mean(axis=2)
        assert np.abs(mesh.points[cells[:, corners:]] - middles).max() < 1e-9
    if suffix in (".vtk", ".vtu"):
        data = other.cell_data_dict["group"]
        assert (data[solid] == SOLID_TAG).all()
        for name, facets in mesh.facets.items():
            of_group = other.cells_dict[facet][data[facet] == SURFACE_TAGS[name]]
            assert np.array_equal(of_group, facets)
    elif suffix == ".msh":
        assert set(other.field_data) == {"solid", *mesh.facets}
    else:
        assert set(other.point_sets) == set(mesh.facets)
        assert list(other.cell_sets) == ["solid"]


@pytest.mark.parametrize(
    ("nodes", "kind"),
    [(4, "Tetrahedron"), (10, "Tetrahedron"), (8, "Hexahedron"), (20, "Hexahedron")],
)
def test_nodes_are_in_the_order_of_gmsh(nodes: int, kind: str) -> None:
    """Gmsh gives the reference coordinates of its elements' nodes."""
    shape = BY_NODES[nodes]
    with session("test"):
        number = gmsh.model.mesh.getElementType(kind, shape.order(nodes), serendip=True)
        _, _, _, count, local, _ = gmsh.model.mesh.getElementProperties(number)
    assert count == nodes
    theirs = local.reshape(-1, 3)
    ours = np.concatenate([shape.reference, shape.reference[shape.edges].mean(axis=1)])[:nodes]
    assert np.array_equal(theirs if shape is TETRAHEDRON else (theirs + 1) / 2, ours)


def test_faces_of_hexahedra_are_those_of_abaqus(
    bricks_second_order: SolidMesh, tmp_path: Path
) -> None:
    """Abaqus' manual: faces of C3D20R by their corners; each element's data on two lines."""
    corners = {"S1": "1234", "S2": "5876", "S3": "1562", "S4": "2673", "S5": "3784", "S6": "4851"}
    path = tmp_path / "box.inp"
    write(path, bricks_second_order)
    blocks = path.read_text().split("*")
    elements = next(b for b in blocks if b.startswith("ELEMENT, TYPE=C3D20R\n")).split("\n", 1)[1]
    assert max(line.count(",") for line in elements.splitlines()) <= 16
    numbers = np.array(elements.replace(",", " ").split(), dtype=int).reshape(-1, 21)
    of = {row[0]: row[1:] - 1 for row in numbers}
    for name, facets in bricks_second_order.facets.items():
        lines = next(b for b in blocks if b.startswith(f"SURFACE, NAME={name}")).splitlines()[1:]
        found = set()
        for line in lines:
            element, face = line.split(", ")
            found.add(frozenset(of[int(element)][[int(c) - 1 for c in corners[face]]]))
        assert found == {frozenset(corners) for corners in facets[:, :4]}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(
    ("suffix", "version", "binary"), [(".msh", 2.2, 1), (".msh", 4.1, 0), (".inp", 4.1, 0)]
)
def test_hexahedra_of_gmsh(
    order: int, suffix: str, version: float, binary: int, tmp_path: Path
) -> None:
    path = tmp_path / f"theirs{suffix}"
    options = {
        "Mesh.MshFileVersion": version, "Mesh.Binary": binary, "Mesh.SecondOrderIncomplete": 1,
        "Mesh.RecombineAll": 1, "Mesh.SaveGroupsOfElements": 1,
    }  # fmt: skip
    with session("test", options):
        recombined_box()
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(path))
    found = read(path, needed=["clamp"])
    assert (found.shape, found.order) == (HEXAHEDRON, order)
    assert len(found.cells) == 8
    assert len(found.facets["clamp"]) == 4
    assert np.abs(found.points[found.facets["clamp"], 2]).max() == 0
    assert jacobians(found) == pytest.approx(1 * 2 * 3 / 8)


def recombined_box() -> None:
    """2³ hexahedra in a box of 1 mm × 2 mm × 3 mm in Gmsh's current model."""
    solid = gmsh.model.occ.addBox(0, 0, 0, 1, 2, 3)
    gmsh.model.occ.synchronize()
    for dim, put in ((1, "Curve"), (2, "Surface"), (3, "Volume")):
        for _, tag in gmsh.model.getEntities(dim):
            getattr(gmsh.model.mesh, f"setTransfinite{put}")(tag, *([3] if dim == 1 else []))
    clamp = gmsh.model.getEntitiesInBoundingBox(-1, -1, -0.1, 2, 3, 0.1, 2)
    gmsh.model.addPhysicalGroup(2, [tag for _, tag in clamp], name="clamp")
    gmsh.model.addPhysicalGroup(3, [solid], name="solid")
    gmsh.model.mesh.generate(3)


def test_hexahedra_with_nodes_amid_their_faces_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "theirs.msh"
    with session("test", {"Mesh.RecombineAll": 1}):
        recombined_box()
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(path))
    with pytest.raises(MeshError, match="volume elements: Hexahedron 27; allowed: one of"):
        read(path, needed=[])


@pytest.mark.parametrize("suffix", [".msh", ".inp", ".vtk", ".vtu"])
def test_mixed_elements_are_refused(bricks: SolidMesh, suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"mixed{suffix}"
    cells = [("hexahedron", bricks.cells[:-1]), ("tetra", bricks.cells[-1:, [0, 1, 3, 4]])]
    kind = "gmsh22" if suffix == ".msh" else None
    meshio.write(path, meshio.Mesh(bricks.points, cells), file_format=kind)
    with pytest.raises(MeshError, match=r"(?i)(tetra|C3D4 ).*allowed: ") as caught:
        read(path, needed=[])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", [".vtu", ".inp"])
def test_triangles_on_hexahedra_are_refused(bricks: SolidMesh, suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"triangles{suffix}"
    clamp = bricks.facets["clamp"]
    cells = [("hexahedron", bricks.cells), ("triangle", clamp[:, :3])]
    tags = [np.full(len(bricks.cells), SOLID_TAG), np.full(len(clamp), SURFACE_TAGS["clamp"])]
    sets = {"clamp": [np.array([], dtype=int), np.arange(len(clamp))]}
    if suffix == ".vtu":
        mesh = meshio.Mesh(bricks.points, cells, cell_data={"group": tags})
    else:
        mesh = meshio.Mesh(bricks.points, cells, cell_sets=sets)
    meshio.write(path, mesh)
    with pytest.raises(MeshError, match="clamp: facets of 3 corners on hexahedra; allowed: quad"):
        read(path, needed=[])


def test_quadrilaterals_of_a_deck_are_a_group(bricks: SolidMesh, tmp_path: Path) -> None:
    """Shells by their element set, as Gmsh exports them."""
    path = tmp_path / "shells.inp"
    write(path, bricks)
    lines = []
    for i, facets in enumerate(bricks.facets.values()):
        name = list(bricks.facets)[i]
        kind = ["CPS4", "S4R", "R3D4", "M3D4R", "SFM3D4"][i]
        lines.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        lines += [
            ", ".join(map(str, [1000 * (i + 1) + j, *(facet + 1)]))
            for j, facet in enumerate(facets)
        ]
    text = path.read_text()
    path.write_text("\n".join([text[: text.index("*NSET")], *lines]))
    same(read(path), bricks)


def test_second_order_nodes_are_midpoints(half_second_order: SolidMesh) -> None:
    x = half_second_order.points
    tetrahedra = half_second_order.cells
    middles = x[tetrahedra[:, TETRAHEDRON.edges]].mean(axis=2)
    assert np.abs(x[tetrahedra[:, 4:]] - middles).max() < 1e-9
    for facets in half_second_order.facets.values():
        middles = x[facets[:, [[0, 1], [1, 2], [2, 0]]]].mean(axis=2)
        assert np.abs(x[facets[:, 3:]] - middles).max() < 1e-9


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(
    ("suffix", "version", "binary"),
    [(".msh", 2.2, 0), (".msh", 4.1, 1), (".msh", 4.0, 0), (".inp", 4.1, 0)],
)
def test_files_of_gmsh(
    order: int, suffix: str, version: float, binary: int, tmp_path: Path
) -> None:
    path = tmp_path / f"theirs{suffix}"
    options = {"Mesh.MshFileVersion": version, "Mesh.Binary": binary, "Mesh.MeshSizeMax": 10}
    with session("test", options):
        solid_model.build(Finger(), half=True)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(path))
    found = read(path)
    assert found.order == order
    assert check(found).volume_mm3 == pytest.approx(9508.176, rel=1e-9)
    assert check(found).cavity_mm3 == pytest.approx(3547.824, rel=1e-9)


def test_node_sets_stand_for_surfaces(mesh: SolidMesh, tmp_path: Path) -> None:
    path = tmp_path / "sets.inp"
    write(path, mesh)
    text = path.read_text()
    path.write_text(text[: text.index("*SURFACE")])
    same(read(path), mesh)


def test_a_node_set_claims_no_face_twice(tmp_path: Path) -> None:
    """A cube's base is the clamp's, though all its nodes are the skin's, too."""
    path = tmp_path / "cube.inp"
    corners = [
        "0, 0, 0",
        "1, 0, 0",
        "1, 1, 0",
        "0, 1, 0",
        "0, 0, 1",
        "1, 0, 1",
        "1, 1, 1",
        "0, 1, 1",
    ]
    nodes = [f"{i}, {corner}" for i, corner in enumerate(corners, 1)]
    every = ", ".join(str(i) for i in range(1, 9))
    lines = ["*NODE", *nodes, "*ELEMENT, TYPE=C3D8", f"1, {every}"]
    lines += ["*NSET, NSET=CLAMP", "1, 2, 3, 4", "*NSET, NSET=SKIN", every]
    path.write_text("\n".join(lines) + "\n")
    found = read(path, needed=[])
    assert {name: len(facets) for name, facets in found.facets.items()} == {"clamp": 1, "skin": 5}


def test_deck_in_the_manner_of_abaqus(half: SolidMesh, tmp_path: Path) -> None:
    """Upper case, a part with other numbers, surfaces by element sets and ranges."""
    number = 100 + 10 * np.arange(len(half.points))
    lines = ["*Heading", " a finger", "** comment", "*Part, name=FINGER", "*Node, nset=ALL"]
    lines += [
        f"{n}, {x!r}, {y!r}, {z!r}"
        for n, (x, y, z) in zip(number, half.points.tolist(), strict=True)
    ]
    lines.append("*Element, type=C3D4H, elset=BODY")
    for i, nodes in enumerate(number[half.cells].tolist(), 1):
        a, b, c, d = nodes
        lines += [f"{i}, {a}, {b},", f" {c}, {d}"]
    lines += ["*End Part", "*Nset, nset=ODD, generate", "100, 140, 20"]
    for name, facets in half.facets.items():
        groups: dict[str, list[str]] = {}
        for facet in facets:
            element = np.flatnonzero(np.isin(half.cells, facet).sum(axis=1) == 3)[0]
            away = int(np.flatnonzero(~np.isin(half.cells[element], facet))[0])
            groups.setdefault({3: "S1", 2: "S2", 0: "S3", 1: "S4"}[away], []).append(
                str(element + 1)
            )
        for face, elements in groups.items():
            lines.append(f"*Elset, elset=_{name}_{face}, internal, instance=FINGER-1")
            lines += [", ".join(elements[i : i + 16]) for i in range(0, len(elements), 16)]
        lines.append(f'*Surface, type=ELEMENT, name="{name.upper()}"')
        lines += [f"_{name}_{face}, {face}" for face in groups]
    lines += ["*Material, name=NINJAFLEX", "*Hyperelastic, neo hooke", "1.465, 0.1"]
    path = tmp_path / "theirs.inp"
    path.write_text("\r\n".join(lines))
    same(read(path), half)


def written(mesh: SolidMesh, path: Path, old: str, new: str) -> Path:
    write(path, mesh)
    path.write_text(path.read_text().replace(old, new))
    return path


@pytest.mark.parametrize("suffix", [".msh", ".inp"])
def test_missing_groups(half: SolidMesh, suffix: str, tmp_path: Path) -> None:
    path = written(half, tmp_path / f"finger{suffix}", "skin", "shell")
    with pytest.raises(MeshError) as caught:
        read(path)
    assert str(caught.value) == (
        f"mesh.file = {path}: missing group skin; "
        "needed: cavity, clamp, skin, tip, and symmetry for a half finger"
    )


@pytest.mark.parametrize(
    ("name", "old", "new", "complaint"),
    [
        ("a.inp", "TYPE=C3D4", "TYPE=C3D6", "element type C3D6; allowed: C3D4, C3D10, C3D8"),
        ("a.inp", "TYPE=C3D4", "TYPE=T3D2", "no solid elements; allowed types"),
        ("a.inp", "*NODE", "*INCLUDE, INPUT=x", "line 4: \\*INCLUDE: not supported"),
        ("a.inp", "*NODE\n", "*NODE\n1, zero, 0, 0\n", "line 4: \\*NODE: not understood"),
        ("a.inp", "*NODE\n", "*NODE\n1, 0, 0, 0\n", "node 1 twice; allowed: one part"),
        ("a.inp", ", S1", ", S7", "face 'S7'; allowed: S1 to S4"),
        ("a.inp", "*NODE\n1,", "*NODE\n1000000,", "a node that is not there"),
        # four nodes an element, read by eights: a wrong count, or a number that comes again
        ("a.inp", "TYPE=C3D4", "TYPE=C3D8", "line 295: \\*ELEMENT: "),
        ("a.msh", "$MeshFormat", "Point(1) =", "allowed: a file that starts with"),
        ("a.msh", "$Elements\n", "$Elements\n9 ", "not readable: "),
    ],
)
def test_what_is_no_mesh(
    half: SolidMesh, name: str, old: str, new: str, complaint: str, tmp_path: Path
) -> None:
    path = written(half, tmp_path / name, old, new)
    with pytest.raises(MeshError, match=complaint) as caught:
        read(path)
    assert str(caught.value).startswith(f"mesh.file = {path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["none.msh", "none.inp"])
def test_no_file(name: str, tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"No such file or directory$"):
        read(tmp_path / name)


def test_unknown_suffix(half: SolidMesh, tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"unknown format; allowed: \.msh, \.inp, \.vtk, \.vtu$"):
        read(tmp_path / "finger.stl")
    with pytest.raises(MeshError, match=r"unknown format; allowed: \.msh, \.inp, \.vtk, \.vtu$"):
        write(tmp_path / "finger.stl", half)


@pytest.mark.parametrize("suffix", [".msh", ".inp", ".vtk"])
def test_nothing_is_left_where_writing_fails(half: SolidMesh, suffix: str, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(WriteError, match=r"cannot be written: Not a directory$"):
        write(tmp_path / "file" / f"finger{suffix}", half)
    assert [each.name for each in tmp_path.iterdir()] == ["file"]


def test_missing_folders_are_made(half: SolidMesh, tmp_path: Path) -> None:
    write(tmp_path / "some" / "where" / "finger.msh", half)
    assert [each.name for each in (tmp_path / "some" / "where").iterdir()] == ["finger.msh"]
