"""The command: what it prints, writes and returns, for good and for bad input."""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import matplotlib.image
import pytest
from support import hollow_box
from support.command import run_command

from dolfingrip.config import Config, dumps
from dolfingrip.experiments.simulate import MORE_RANKS_THAN_CORES
from dolfingrip.meshes import files

COARSE = (
    "--set", "mesh.size_mm=6", "--set", "finger.length_mm=38", "--set", "finger.bellows=2",
    "--set", "experiment.max_pressure_kPa=40", "--set", "experiment.step_kPa=10",
)  # fmt: skip
BAD = {
    "value": ["--set", "finger.gap_mm=-1"],
    "unknown key": ["--set", "finger.wall_cm=1"],
    "geometry": ["--set", "finger.wall_mm=4"],
    "too thin to mesh": ["--set", "finger.wall_mm=3.499999"],
    "no configuration": ["--config", "no.toml"],
    "no mesh": ["--set", "mesh.file=no.msh"],
    "mesh of another kind": ["--set", "mesh.file=mesh.txt"],
    "mesh without groups": ["--set", "mesh.file=bare.msh"],
    "render": ["--render", "0,33"],
    "render text": ["--render", "all"],
    "colour": ["--colour-by", "strain"],
}
SAID = {
    "value": "finger.gap_mm = -1: allowed: at least 0.001 and at most 10000 mm",
    "unknown key": "finger.wall_cm: unknown key; did you mean finger.wall_mm?",
    "geometry": "finger.wall_mm = 4.0: thicker than half a bellows; allowed: above 0 and below 3.5",
    "too thin to mesh": "finger.wall_mm = 3.499999: leaves 2e-06 mm between two faces; allowed:",
    "no configuration": "--config no.toml: No such file or directory",
    "no mesh": "no.msh: No such file or directory",
    "mesh of another kind": "mesh.txt: unknown format; allowed: .msh, .inp",
    "mesh without groups": "bare.msh: missing groups cavity, clamp, skin, tip",
    "render": "--render 33: allowed: 0, 25, 50, 75, 100, 125, 150, 175, 200, 225, 250 (kPa)",
    "render text": "--render all: allowed: pressures in kPa",
    "colour": "--colour-by strain: allowed: displacement, stretch",
}
ENVIRONMENT = {
    **os.environ,
    "OMP_NUM_THREADS": "1",
    "HWLOC_HIDE_ERRORS": "2",  # a sandbox without /sys is no concern of ours
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
}
COMMAND = (sys.executable, "-P", "-m", "dolfingrip")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with bad mesh files."""
    tetrahedron = "4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
    (tmp_path / "bare.msh").write_text(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
        f"$Nodes\n{tetrahedron}$EndNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n"
    )
    (tmp_path / "mesh.txt").write_text("nothing")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("kind", BAD)
def test_bad_input_is_one_line_exit_code_2_and_nothing_written(
    kind: str, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    before = sorted(folder.iterdir())
    assert run_command("bend", "--out", "results", *BAD[kind]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("dolfingrip: ")
    assert SAID[kind] in err
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize("command", ["bend", "force", "mesh", "demo"])
@pytest.mark.parametrize("out", ["mesh.txt", "mesh.txt/results"])
def test_a_file_in_the_way_of_results_is_named(
    command: str,
    out: str,
    folder: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert run_command(command, "--out", out) == 2
    said = f"dolfingrip: --out {out}: {folder / 'mesh.txt'} is a file; allowed: a folder\n"
    assert capfd.readouterr() == ("", said)


def test_printed_configuration_is_the_resolved_one(capfd: pytest.CaptureFixture[str]) -> None:
    assert run_command("config") == 0
    assert capfd.readouterr().out == dumps(Config())
    assert run_command("config", "--set", "finger.wall_mm=1.8") == 0
    assert "\nwall_mm = 1.8 # walls of bellows and channel\n" in capfd.readouterr().out


def test_usage_errors_keep_their_form(capfd: pytest.CaptureFixture[str]) -> None:
    assert run_command("bend", "--nothing") == 2
    assert "No such option: --nothing" in capfd.readouterr().err


@pytest.mark.slow
def test_force_writes_table_curve_and_renders(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arguments = ("force", "--out", str(tmp_path), *COARSE, "--render", "0,40")
    code = run_command(*arguments, "--colour-by", "stretch")
    out, err = capfd.readouterr()
    assert (code, err) == (0, "")
    assert re.search(r"Blocked\n.* force\n.* \(N\)\n", out)
    assert f"results: {tmp_path}\n" in out
    assert not out.startswith("\n")  # no trace of a progress bar
    for name in ("curve", "finger_0kPa", "finger_40kPa", "strip"):
        picture = matplotlib.image.imread(tmp_path / f"{name}.png")
        assert picture[..., :3].std() > 0.01, name
    record = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert record["command"] == [*arguments, "--colour-by", "stretch"]

    again = tmp_path / "again"
    code = run_command(
        "force", "--config", str(tmp_path / "run.json"), "--out", str(again)
    )  # fmt: skip
    assert code == 0
    assert (again / "result.csv").read_bytes() == (tmp_path / "result.csv").read_bytes()
    assert not list(again.glob("finger*.png"))


def test_a_path_that_ends_early_is_told_and_exits_with_1(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    settings = ("solver.max_iterations=1", "solver.rtol=1e-12", "solver.min_step_kPa=20")
    one = [word for setting in settings for word in ("--set", setting)]
    code = run_command("bend", "--out", str(tmp_path), *COARSE, *one, "--render", "0,40")
    out, _ = capfd.readouterr()
    assert code == 1
    assert "Free bending stopped at 0 kPa (" in out
    assert len((tmp_path / "result.csv").read_text(encoding="utf-8").splitlines()) == 2
    assert (tmp_path / "finger_0kPa.png").exists()
    assert not (tmp_path / "finger_40kPa.png").exists()


def test_a_second_run_that_ends_early_is_told_and_exits_with_1(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Linear elements get along with one iteration a step, which the second run's do not."""
    settings = (
        "extensions.locking={}", "solver.max_iterations=1", "solver.min_step_kPa=20",
        "solver.max_step_kPa=50", "experiment.max_pressure_kPa=50", "experiment.step_kPa=50",
        "mesh.edge_size_mm=6",
    )  # fmt: skip
    one = [word for setting in settings for word in ("--set", setting)]
    asked = ("--gradients", "--parameters", "extensions.locking")
    code = run_command("bend", "--out", str(tmp_path), *COARSE, *one, *asked)
    out, _ = capfd.readouterr()
    assert code == 1
    assert "extensions.locking: a choice of the model, which has no derivative. A second run" in out
    assert "Free bending, the second run for extensions.locking stopped at 0 kPa (" in out
    rows = (tmp_path / "result.csv").read_text(encoding="utf-8").splitlines()[1:]
    found = (tmp_path / "sensitivity.csv").read_text(encoding="utf-8").splitlines()[1:]
    assert len(rows) == 2
    assert {line.split(",")[0] for line in found} == {"0"}  # as far as both got
    record = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert record["complete"]
    assert record["second_runs"]["extensions.locking"].startswith("stopped at 0 kPa")


def test_linear_elements_are_warned_of(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    linear = ("--set", "solver.element=P1", "--set", "contact.self_contact=false")
    code = run_command("bend", "--out", str(tmp_path), *COARSE, *linear)
    assert code == 0
    said = [line for line in capfd.readouterr().out.splitlines() if "warning" in line]
    assert len(said) == 1
    assert "linear tetrahedra are too stiff in thin walls" in said[0]
    record = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert [f"warning: {note}" for note in record["notes"]] == said


def test_mesh_writes_what_can_be_read_back(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "mesh"
    assert run_command("mesh", "--out", str(out), *COARSE) == 0
    said, err = capfd.readouterr()
    assert err == ""
    assert sorted(file.name for file in out.iterdir()) == ["finger.inp", "finger.msh", "finger.vtk"]
    for name in ("finger.msh", "finger.inp"):
        assert f"wrote {out / name}\n" in said
        arguments = ("mesh", "--out", str(tmp_path / name), "--set", f"mesh.file={out / name}")
        assert run_command(*arguments) == 0
        assert capfd.readouterr().out.splitlines()[0] == said.splitlines()[0]


@pytest.mark.parametrize(
    ("settings", "elements"),
    [
        ([], "hexahedra of order 2, "),
        (["solver.element=P2"], "tetrahedra of order 2, "),
        (["solver.element=P2-P1"], "tetrahedra of order 2, "),
        (["mesh.target_elements=3000"], "tetrahedra of order 2, "),
        (["solver.element=P1"], "tetrahedra of order 1, "),
        (["mesh.order=1"], "hexahedra of order 1, "),
        (["solver.element=P1", "mesh.order=2"], "tetrahedra of order 2, "),
    ],
)
def test_mesh_has_the_elements_of_the_solver_or_those_asked_for(
    settings: list[str],
    elements: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    asked = [word for setting in settings for word in ("--set", setting)]
    arguments = ("mesh", "--out", str(tmp_path), *COARSE, *asked)
    assert run_command(*arguments) == 0
    assert elements in capfd.readouterr().out
    for name in ("finger.msh", "finger.inp", "finger.vtk"):
        mesh = files.read(tmp_path / name)
        assert f"{mesh.shape.plural} of order {mesh.order}, " == elements


@pytest.mark.parametrize("order", [1, 2])
def test_a_mesh_file_is_written_in_the_order_asked_for(order: int, tmp_path: Path) -> None:
    before = hollow_box.mesh(3 - order)
    files.write(tmp_path / "box.vtk", before)
    asked = ("--set", f"mesh.file={tmp_path / 'box.vtk'}", "--set", f"mesh.order={order}")
    assert run_command("mesh", "--out", str(tmp_path / "out"), *asked) == 0
    after = files.read(tmp_path / "out" / "finger.inp")
    assert after.order == order
    assert len(after.cells) == len(before.cells)
    assert {k: len(v) for k, v in after.facets.items()} == {
        k: len(v) for k, v in before.facets.items()
    }


@pytest.mark.parametrize(
    ("number", "code", "word"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
)
def test_interrupt_is_quiet(number: signal.Signals, code: int, word: str, tmp_path: Path) -> None:
    """Ctrl-C in the middle: exit code 130, no traceback, rows so far kept, which one line says."""
    steps = ("--set", "experiment.step_kPa=0.5")
    run = subprocess.Popen(
        [*COMMAND, "bend", "--out", str(tmp_path), *COARSE, *steps],
        env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    table = tmp_path / "result.csv"
    for _ in range(6000):  # forms may have to be compiled first
        assert run.poll() is None
        if table.exists() and len(table.read_text(encoding="utf-8").splitlines()) > 2:
            break
        time.sleep(0.1)
    run.send_signal(number)
    out, err = run.communicate(timeout=60)
    assert (run.returncode, out) == (code, "")
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 1
    reached = float(rows[-1]["pressure_kPa"])
    sentence = (
        f"{len(rows)} readings, up to {reached:g} kPa, are kept in {tmp_path}; "
        "the same command starts from the beginning"
    )
    assert err == f"dolfingrip: {word}: {sentence}\n"
    record = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert record["complete"] is False
    assert record["failure"]["kind"] == "interrupted"
    assert record["failure"]["sentence"] == sentence
    assert record["failure"]["last_good"]["pressure_kPa"] == pytest.approx(reached)


@pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun")
@pytest.mark.parametrize("kind", ["value", "too thin to mesh", "no mesh", "render"])
def test_bad_input_on_two_ranks_is_said_once_and_ends_all(kind: str, tmp_path: Path) -> None:
    """Meshing fails on rank 0 alone: the other must not wait for it for ever."""
    ended = subprocess.run(
        ["mpirun", "-n", "2", *COMMAND, "bend", "--out", "results", *BAD[kind]],
        env=_outside_mpi() | MORE_RANKS_THAN_CORES, capture_output=True, text=True, timeout=90,
        cwd=tmp_path, check=False, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert ended.returncode == 2
    ours = [line for line in ended.stderr.splitlines() if line.startswith("dolfingrip: ")]
    assert len(ours) == 1
    assert SAID[kind] in ours[0]
    assert "Traceback" not in ended.stderr
    assert not (tmp_path / "results").exists()


def _outside_mpi() -> dict[str, str]:
    """The environment without what this process' own MPI put there."""
    return {
        name: value
        for name, value in ENVIRONMENT.items()
        if not name.startswith(("OMPI_MCA_", "OMPI_COMM_", "PMIX_", "OPAL_", "PRTE_"))
    }
