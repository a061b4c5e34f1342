"""Collections as dolfinx writes them: linear, quadratic, in pieces; steps and pressures."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista as pv
from support import synthetic_run

from dolfingrip.files.table import read_csv
from dolfingrip.meshes.cells import HEXAHEDRON, TETRAHEDRON
from dolfingrip.report.fields import (
    find_steps,
    list_steps,
    read_grid,
    read_mesh,
    read_point_data,
    read_steps,
)
from dolfingrip.report.skin import extract_skin


def test_every_step_is_listed_in_the_order_written(run: Path) -> None:
    files = list_steps(run / "fields.pvd")
    assert len(files) == len(synthetic_run.PRESSURES_KPA)
    assert all(file.is_file() for file in files)


def test_nodal_values_are_those_of_the_field(run: Path) -> None:
    grid = read_grid(list_steps(run / "fields.pvd")[3])
    mesh = read_mesh(grid)
    angle = synthetic_run.angle_deg(3)
    u = read_point_data(grid, "displacement_mm", mesh.source)
    stretch = read_point_data(grid, "principal_stretch", mesh.source)
    np.testing.assert_allclose(u, synthetic_run.bend(mesh.points.T, angle).T, atol=1e-9)
    np.testing.assert_allclose(
        stretch, 1 + np.radians(angle) / synthetic_run.LENGTH_MM * mesh.points[:, 0], atol=1e-12
    )


def test_quadratic_nodes_sit_in_the_middle_of_their_edges_and_faces(run: Path) -> None:
    mesh = read_mesh(read_grid(list_steps(run / "fields.pvd")[0]))
    nodes = mesh.cells.shape[1]
    assert nodes in (4, 10, 8, 27)
    shape = TETRAHEDRON if nodes in (4, 10) else HEXAHEDRON
    within = [*shape.edges, *shape.face_corners, np.arange(8)][: nodes - shape.corners]
    for node, corners in enumerate(within, start=shape.corners):
        middle = mesh.points[mesh.cells[:, corners]].mean(axis=1)
        np.testing.assert_allclose(mesh.points[mesh.cells[:, node]], middle, atol=1e-9)


def test_quadratic_hexahedra_of_others_are_read() -> None:
    """VTK's own cell of 20 nodes: each sits amid its edge."""
    cell = pv.examples.cells.QuadraticHexahedron()
    mesh = read_mesh(cell)
    assert mesh.cells.shape == (1, 20)
    x = mesh.points[mesh.cells[0]]
    np.testing.assert_allclose(x[8:], x[HEXAHEDRON.edges].mean(axis=1), atol=1e-12)


def test_pieces_and_ghosts_are_joined_without_a_seam(quadratic_run: Path, tmp_path: Path) -> None:
    file = list_steps(quadratic_run / "fields.pvd")[4]
    whole = read_grid(file)
    joined = read_grid(_write_in_two_pieces(whole, tmp_path))
    assert joined.n_cells > whole.n_cells
    one, two = read_mesh(whole), read_mesh(joined)
    assert two.points.shape == one.points.shape
    assert two.cells.shape == one.cells.shape
    assert len(extract_skin(two).triangles) == len(extract_skin(one).triangles)
    u = read_point_data(joined, "displacement_mm", two.source)
    expected = synthetic_run.bend(two.points.T, synthetic_run.angle_deg(4)).T
    np.testing.assert_allclose(u, expected, atol=1e-9)  # stale ghosts are not looked at


def test_steps_follow_pressure_and_branch(run: Path) -> None:
    result = read_csv(run / "result.csv")
    assert find_steps(result, [0, 100, 200]) == [0, 2, 4]
    assert find_steps(result, [100], branch="unloading") == [6]
    assert find_steps({"pressure_kPa": [0.0, 12.5, 25.0]}, [12.5]) == [1]
    back = {"pressure_kPa": [0, -60, -30, 0], "branch": [*2 * ["loading"], *2 * ["unloading"]]}
    assert find_steps(back, [-60, 0, -30]) == [1, 0, 2]  # -30 kPa is only on the way back


def test_unknown_pressure_is_named_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match=r"^pressure_kPa = 110: .*allowed: 0, 50, 100$"):
        find_steps({"pressure_kPa": [0, 50, 100]}, [50, 110])


def test_unknown_branch_is_named_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match=r"^branch = unloading: allowed: loading$"):
        find_steps({"pressure_kPa": [0, 50]}, [50], branch="unloading")


def test_missing_file_and_missing_array_are_named(run: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"nowhere\.pvd: No such file"):
        list_steps(tmp_path / "nowhere.pvd")
    grid = read_grid(list_steps(run / "fields.pvd")[0])
    with pytest.raises(ValueError, match="no point data velocity; there are"):
        read_point_data(grid, "velocity", read_mesh(grid).source)


def test_other_cells_are_refused() -> None:
    bricks = pv.ImageData(dimensions=(2, 2, 2)).cast_to_unstructured_grid()
    assert set(bricks.celltypes) == {11}  # voxels, their nodes in another order
    with pytest.raises(ValueError, match="linear or quadratic tetrahedra or hexahedra"):
        read_mesh(bricks)
    with pytest.raises(ValueError, match="linear or quadratic tetrahedra or hexahedra"):
        read_mesh(pv.UnstructuredGrid())


def _write_in_two_pieces(grid: pv.UnstructuredGrid, folder: Path) -> Path:
    """The grid as two ranks would write it: each with a layer of ghosts, their values stale."""
    z = grid.cell_centers().points[:, 2]
    arrays = "".join(
        f'<PDataArray type="Float64" Name="{name}" NumberOfComponents="{size}"/>'
        for name, size in (("displacement_mm", 3), ("principal_stretch", 1))
    )
    flags = '<PDataArray type="UInt8" Name="vtkGhostType"/>'
    for rank, owned in enumerate((z < 45.0, z >= 45.0)):
        near = owned | (np.abs(z - 45.0) < 4.0)
        piece = grid.extract_cells(np.flatnonzero(near))
        ghost = ~owned[near]
        piece.cell_data["vtkGhostType"] = ghost.astype(np.uint8)
        held = np.unique(piece.cell_connectivity.reshape(piece.n_cells, -1)[~ghost])
        stale = np.ones(piece.n_points, dtype=bool)
        stale[held] = False
        piece.point_data["vtkGhostType"] = stale.astype(np.uint8)
        piece.point_data["displacement_mm"][stale] = 99.0
        for name in list(piece.point_data):
            if name not in ("displacement_mm", "principal_stretch", "vtkGhostType"):
                del piece.point_data[name]
        for name in list(piece.cell_data):
            if name != "vtkGhostType":
                del piece.cell_data[name]
        piece.save(folder / f"piece_{rank}.vtu")
    file = folder / "step.pvtu"
    file.write_text(
        '<?xml version="1.0"?><VTKFile type="PUnstructuredGrid" version="1.0">'
        f'<PUnstructuredGrid GhostLevel="1"><PPointData>{arrays}{flags}</PPointData>'
        f"<PCellData>{flags}</PCellData>"
        '<PPoints><PDataArray type="Float64" NumberOfComponents="3"/></PPoints>'
        '<Piece Source="piece_0.vtu"/><Piece Source="piece_1.vtu"/>'
        "</PUnstructuredGrid></VTKFile>",
        encoding="utf-8",
    )
    return file


@pytest.mark.parametrize(
    ("suffix", "was", "put", "said"),
    [
        (".vtu", b"</VTKFile>", b"", "damaged: no elements, or points that are no numbers"),
        (".vtu", b"<Points>", b"<Pts<\0", "damaged: no elements, or points that are no numbers"),
        (
            ".pvtu",
            b'NumberOfComponents="3"',
            b'NumberOfComponents="1000000"',
            'damaged: NumberOfComponents="1000000',
        ),
    ],
)
def test_damaged_fields_are_one_line(
    suffix: str,
    was: bytes,
    put: bytes,
    said: str,
    run: Path,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
) -> None:
    """VTK says nothing of it, and takes no memory for a million components."""
    shutil.copytree(run, tmp_path / "run")
    step = list_steps(tmp_path / "run" / "fields.pvd")[0]
    file = step if suffix == ".pvtu" else next((tmp_path / "run").glob("*_000000.vtu"))
    content = file.read_bytes()
    assert was in content
    file.write_bytes(content.replace(was, put))
    with pytest.raises(ValueError, match=re.escape(said)):
        read_grid(step)
    assert "".join(capfd.readouterr()) == ""
    assert not caplog.records


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda grid: np.put(grid.cell_connectivity, 0, grid.n_points), "nodes that it has not"),
        (lambda grid: np.put(grid.cell_connectivity, 0, -1), "nodes that it has not"),
        (lambda grid: np.put(grid.points, 0, 1e300), "points that are no numbers"),
        (lambda grid: np.put(grid.point_data["displacement_mm"], 0, 1e300), "displacements that"),
        (lambda grid: np.put(grid.point_data["displacement_mm"], 0, np.nan), "displacements that"),
    ],
)
def test_numbers_that_no_body_has_are_one_line(
    damage: Callable[[Any], None], said: str, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that VTK reads, with nodes or places that mean nothing."""
    step = list_steps(run / "fields.pvd")[-1]
    grid = read_grid(step)
    damage(grid)
    monkeypatch.setattr("dolfingrip.report.fields.vtk_file.read", lambda file: grid)
    with pytest.raises(ValueError, match=f"{step.name}: damaged: .*{said}"):
        read_steps([step])
