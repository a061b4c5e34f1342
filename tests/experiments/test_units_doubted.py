"""Units of parts and moduli are doubted before anything is computed."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from mpi4py import MPI
from support import hollow_bar, hollow_box
from support.command import run_command

from dolfingrip import config
from dolfingrip.config import Config
from dolfingrip.experiments import run
from dolfingrip.experiments.finger_experiment import notes
from dolfingrip.meshes import files
from dolfingrip.sections.units import UNITS_MM


@pytest.mark.parametrize(("given", "said"), [
    (2930.0, "material.mu_MPa: a shear modulus of 2930 MPa, .* in kPa[?] It is 2.93 MPa then"),
    (554.0, "in kPa[?] It is 0.554 MPa then"),
    (2.93e5, "in Pa[?] It is 0.293 MPa then"),
    (2.93e-4, "in GPa[?] It is 0.293 MPa then"),
])  # fmt: skip
def test_a_modulus_in_another_unit(given: float, said: str) -> None:
    found = notes(Config().changed(material={"mu_MPa": given}))
    assert any(re.search(said, each) for each in found)


@pytest.mark.parametrize("given", [0.005, 0.2, 2.93, 20.0])
def test_a_rubber_is_not_doubted(given: float) -> None:
    assert notes(Config().changed(material={"mu_MPa": given, "nu": 0.45})) == []


@pytest.mark.parametrize("unit", ["m", "in", "cm"])
def test_the_unit_of_a_file(tmp_path: Path, capfd: pytest.CaptureFixture[str], unit: str) -> None:
    """The same part as one in mm; without its unit it is doubted, with the factor."""
    part = hollow_bar.stl(tmp_path / "bar.stl", scale=1 / UNITS_MM[unit])
    assert run_command("adopt", part, "--unit", unit, "--out", tmp_path) == 0
    said = capfd.readouterr().out
    assert "long: in another unit" not in said
    written = config.load(tmp_path / "adopted.toml").geometry
    assert written.length_mm == pytest.approx(50.0, rel=1e-4)
    assert run_command("adopt", part, "--out", tmp_path / "mm") == 0
    said = capfd.readouterr().out
    length = {"m": "0.05", "in": "1.969", "cm": "5"}[unit]
    assert f"{length} mm long: in another unit? --unit" in said
    assert f"--unit {unit} makes 50 mm of it" in said
    tiny = config.load(tmp_path / "mm" / "adopted.toml")
    assert any(f"--unit {unit} makes 50 mm of it" in each for each in notes(tiny))
    assert run_command("adopt", part, "--scale", "25.4") == 2


@pytest.mark.parametrize(("scale", "doubts"), [(1.0, 0), (1e-3, 1)])
def test_the_unit_of_a_mesh_whose_length_no_table_tells(
    tmp_path: Path, scale: float, doubts: int
) -> None:
    """The length is the mesh's own: 15 mm, or as many metres."""
    box = hollow_box.mesh()
    files.write(tmp_path / "box.msh", replace(box, points=scale * box.points))
    asked = {"mesh.file": str(tmp_path / "box.msh"), "finger.kind": "adopted"}
    found = [each for each in notes(config.load(None, asked)) if "in another unit?" in each]
    assert len(found) == doubts
    assert all(
        each.startswith("mesh.file: ") and "--unit m makes 15 mm of it" in each for each in found
    )


def test_the_first_pressure_that_is_advised(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Walls strain there by 10 to 40 %, where the closed form says 20 %."""
    part = hollow_bar.stl(tmp_path / "bar.stl")
    assert run_command("adopt", part, "--out", tmp_path) == 0
    said = capfd.readouterr().out
    assert "material:       not known; 2.93 MPa is NinjaFlex's" in said
    (after,) = (line for line in said.splitlines() if line.startswith("next: dolfingrip bend"))
    assert "--set material.mu_MPa=2.93" in after
    first_kPa = float(after.rpartition("--pressure ")[2])
    asked = config.load(
        tmp_path / "adopted.toml",
        {"experiment.max_pressure_kPa": first_kPa, "experiment.step_kPa": first_kPa / 2,
         "solver.element": "P2"},
    )  # fmt: skip
    result = run("bending", asked, comm=MPI.COMM_SELF)
    assert result.failure is None
    assert 1.1 < result.column("largest_stretch")[-1] < 1.4
