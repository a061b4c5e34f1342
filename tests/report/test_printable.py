"""Exported solids: closed, of the volume that the dimensions and the morph give.

References: the volume of a design's mesh (half of it, by the divergence theorem), and OpenCASCADE's
of the STEP file as it is read again.
"""

from __future__ import annotations

from pathlib import Path

import gmsh
import pytest
import pyvista as pv
from support.command import run_command

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.meshes.adoption import formats
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.measures import jacobians
from dolfingrip.report import printable
from dolfingrip.sections.form import Form
from dolfingrip.sections.geometry.boxes import BoxSolid
from dolfingrip.sections.tables import assignments

SHORT = ("finger.length_mm=38", "finger.bellows=2", "mesh.size_mm=8", "mesh.edge_size_mm=8")
DESIGNS = {
    "bellows": SHORT,
    "morphed": (*SHORT, "morph.xi1=0.4", "morph.xi2=-0.3"),
    "tetrahedra": (*SHORT, "solver.element=P2"),
    "whole": (*SHORT, "mesh.half=false"),
    "cast": ("finger.kind=cast", "mesh.size_mm=8", "mesh.edge_size_mm=8"),
    "pneunet": ("finger.kind=pneunet", "mesh.size_mm=8", "mesh.edge_size_mm=8"),
}


def whole_mm3(design: Config) -> float:
    """Volume of a whole design by its linear mesh, of parallelepipeds and tetrahedra."""
    mesh = solid(design.changed(mesh={"order": 1}))
    share = jacobians(mesh).mean(axis=1) / (6 if mesh.shape.corners == 4 else 1)
    return float(share.sum()) * (2 if design.mesh.half else 1)


@pytest.mark.parametrize("name", DESIGNS)
def test_closed_and_of_the_right_volume(tmp_path: Path, name: str) -> None:
    design = config.load(None, assignments(DESIGNS[name]))
    expected = whole_mm3(design)
    stl, step = tmp_path / "design.stl", tmp_path / "design.step"
    written = printable.write(design, stl)
    assert written.volume_mm3 == pytest.approx(expected, rel=1e-9)
    assert written.voids == (name != "cast")  # whose tube is open
    read = pv.read(stl).clean()
    assert read.is_manifold
    assert read.n_open_edges == 0
    assert read.volume == pytest.approx(expected, rel=1e-6)
    drawn = printable.write(design, step)
    assert drawn.volume_mm3 == pytest.approx(expected, rel=1e-9)
    assert drawn.voids == written.voids
    packed_design = printable.write(design, tmp_path / "design.3mf")
    assert packed_design.volume_mm3 == pytest.approx(expected, rel=1e-9)
    packed = pv.PolyData.from_regular_faces(*formats.triangles_of(tmp_path / "design.3mf", 1.0))
    assert packed.n_open_edges == 0
    assert packed.volume == pytest.approx(expected, rel=1e-6)
    with session("read again"):
        gmsh.model.occ.importShapes(str(step))
        volumes = [gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.occ.getEntities(3)]
    assert volumes == pytest.approx([expected], rel=1e-9)
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "design.3mf", "design.step", "design.stl",
    ]  # fmt: skip


def test_a_mesh_file_has_no_step(tmp_path: Path) -> None:
    from dolfingrip.meshes import files

    design = config.load(None, assignments([*SHORT, "mesh.order=1"]))
    files.write(tmp_path / "finger.msh", solid(design))
    unsized = {"file": tmp_path / "finger.msh", "size_mm": None, "edge_size_mm": None}
    design = design.changed(mesh=unsized)
    with pytest.raises(ConfigError, match=r"\.step: a mesh file has no boxes; allowed: \.stl"):
        printable.write(design, tmp_path / "a.step")
    assert printable.write(design, tmp_path / "a.stl").volume_mm3 > 0


def test_a_free_form_has_no_step(tmp_path: Path) -> None:
    """Also where its offsets are 0, so that the volume is that of the boxes."""
    design = config.load(None, assignments(SHORT))
    solid_of = design.geometry.solid()
    assert isinstance(solid_of, BoxSolid)
    count = Form(offsets_mm=()).count(solid_of)
    bent = config.load(None, assignments([*SHORT, f"form.offsets_mm={[0.0] * count}"]))
    with pytest.raises(ConfigError, match=r"\.step: \[form\] bends this design's faces.*\.stl"):
        printable.write(bent, tmp_path / "a.step")


def test_the_command(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    files = [
        tmp_path / f"a.{suffix}" for suffix in ("stl", "step", "toml", "3mf", "inp", "py", "xml")
    ]
    options = [text for each in SHORT for text in ("--set", each)]
    assert run_command("export", *map(str, files), *options) == 0
    said = capfd.readouterr()
    assert not said.err
    assert [line.split(": ")[0] for line in said.out.splitlines()] == [f"wrote {f}" for f in files]
    assert "the file has half of the finger" in said.out
    assert config.load(files[2]).finger.length_mm == 38
    # `robot` and others take it as it stands here: the default finger would replace it
    before = files[2].read_bytes()
    assert run_command("export", str(files[4]), str(files[2])) == 2
    assert "holds another configuration; allowed: a new name, or --config" in capfd.readouterr().err
    assert files[2].read_bytes() == before
    assert run_command("export", str(files[2]), "--config", str(files[2])) == 0
