"""Round trips, files of others, and what is refused."""

from __future__ import annotations

from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest

from dolfingrip.config import Finger
from dolfingrip.meshes import finger as geometry
from dolfingrip.meshes.cells import TETRAHEDRON
from dolfingrip.meshes.files import read, write
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.groups import SOLID_TAG, SURFACE_TAGS
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh

MESHES = ["half", "half_second_order", "whole"]


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
    solid, facet = ("tetra", "triangle") if mesh.order == 1 else ("tetra10", "triangle6")
    tetrahedra = other.cells_dict[solid]
    assert np.abs(other.points - mesh.points).max() < 1e-12
    assert np.array_equal(np.sort(tetrahedra), np.sort(mesh.cells))
    if mesh.order == 2:
        assert np.array_equal(tetrahedra, mesh.cells[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]])
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
        geometry.build(Finger(), half=True)
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
    with pytest.raises(MeshError, match=r"cannot be written: No such file or directory$"):
        write(tmp_path / "none" / f"finger{suffix}", half)
    assert not list(tmp_path.iterdir())
