"""One of each kind of thing is added by a file outside the package, and the commands run with all.

The files in ``tests/additions`` are made up.
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest
from support.checkout import needs_checkout

from dolfingrip.plugins import VARIABLE

ROOT = Path(__file__).resolve().parents[1]
MADE_UP = Path(__file__).parent / "additions"

pytestmark = needs_checkout


ADDITIONS = {
    "a kind of geometry": "block",
    "a strain energy as base law": "stiffening",
    "an effect": "force_square",
    "a food": "egg",
    "a quantity of a design": "print_time",
    "an experiment": "stretch",
    "a result file and its page": "tally",
}


PROCESS = """
import contextlib, io, json, os, sys
answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # what libraries print by themselves is no answer
from dolfingrip.cli.commands import app
for line in sys.stdin:
    folder, calls, code = json.loads(line)
    os.chdir(folder)
    said = []
    for work in (*calls, code):
        with contextlib.redirect_stdout(io.StringIO()) as told:
            if work is code:
                exec(code, {})
            else:
                assert not app(work, prog_name="dolfingrip", standalone_mode=False), work
        said.append(told.getvalue())
    print(json.dumps(said), file=answers, flush=True)
"""

Run = Callable[..., list[str]]


@pytest.fixture(scope="module")
def run() -> Iterator[Run]:
    """Runs commands in a process that has all plugins: one for all tests, as imports take seconds.

    Its arguments are the folder to work in, a list of arguments for each command, and ``then``,
    code that follows. It returns what each command printed, and last what the code did.
    """
    files = [str(MADE_UP / f"{name}.py") for name in ADDITIONS.values()]
    with subprocess.Popen(
        [sys.executable, "-P", "-c", PROCESS], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        text=True, env={**os.environ, VARIABLE: os.pathsep.join(files)},
    ) as process:  # fmt: skip
        assert process.stdin is not None
        assert process.stdout is not None
        asked, answers = process.stdin, process.stdout

        def ran(folder: Path, *calls: Sequence[str], then: str = "") -> list[str]:
            print(json.dumps([str(folder), calls, then]), file=asked, flush=True)
            answer = answers.readline()
            assert answer, "an error, which is told above, has ended the process"
            return list(json.loads(answer))

        yield ran
        asked.close()


def column(folder: Path, name: str) -> list[float]:
    """Numbers of a run's result."""
    with (folder / "result.csv").open(encoding="utf-8", newline="") as text:
        return [float(row[name]) for row in csv.DictReader(text)]


def test_the_geometry_is_meshed_and_bends(tmp_path: Path, run: Run) -> None:
    chosen = ("--set", "finger.kind=block", "--set", "mesh.size_mm=12",
              "--set", "mesh.edge_size_mm=12")  # fmt: skip
    pressed = ("--set", "experiment.max_pressure_kPa=10", "--set", "plate.contact_length_mm=5",
               "--set", "material.mu_MPa=0.1")  # fmt: skip
    thicker = {"extensions.wall_offset.offset_mm": 0.5}
    code = (
        "from dolfingrip.config import load\n"
        "from dolfingrip.parameter import every\n"
        f"config = load(None, {{'finger.kind': 'block', **{thicker}}})\n"
        "print(config.adapted().geometry.wall_mm, [p.key for p in every(config)])"
    )
    meshed, bent, told = run(
        tmp_path, ["mesh", *chosen, "--out", "mesh"], ["bend", *chosen, *pressed, "--out", "bend"],
        then=code,
    )  # fmt: skip
    assert "cavity" in meshed
    assert "Free bending" in bent
    assert abs(column(tmp_path / "bend", "angle_deg")[-1]) > 0.01
    assert told.startswith("4.5 ")
    assert "block.floor_mm" in told


def test_the_law_pulls_and_is_fitted(tmp_path: Path, run: Run) -> None:
    pull = ("--set", "coupon.max_strain=0.5", "--set", "coupon.step_strain=0.5",
            "--set", "material.bulk_MPa=1000", "--set", "material.law=stiffening")  # fmt: skip
    readings = ROOT / "examples" / "coupons" / "ecoflex30_uniaxial.csv"
    fit = ["coupon", "--fit", str(readings), "--law", "stiffening", "--max-stretch", "2.5"]
    _, said, _ = run(tmp_path, ["coupon", *pull, "--out", "coupon"], [*fit, "--out", "fit"])
    stretch = 1.5
    i = stretch**2 + 2 / stretch - 3
    expected = (stretch - stretch**-2) * (1 + 2 * 0.1 * i)
    assert column(tmp_path / "coupon", "nominal_stress_MPa")[-1] == pytest.approx(
        expected, rel=1e-3
    )
    assert "Stiffening" in said
    assert 'law = "stiffening"' in (tmp_path / "fit" / "material.toml").read_text(encoding="utf-8")


def test_the_effect_is_displayed_and_tried(tmp_path: Path, run: Run) -> None:
    pull = ("--set", "coupon.max_strain=0.1", "--set", "coupon.step_strain=0.1")
    square = ("--set", "extensions.force_square.square_per_N=0.1")
    code = (
        "from dolfingrip.config import Config\n"
        "from dolfingrip.diagnosis.core.unknown import causes\n"
        "print([len(e.numbers) for e in causes(Config(), ['force_square'])])"
    )
    *_, listed, numbers = run(
        tmp_path, ["coupon", *pull, "--out", "plain"],
        ["coupon", *pull, *square, "--out", "square"], ["extensions"], then=code,
    )  # fmt: skip
    plain, shown = (column(tmp_path / name, "force_N")[-1] for name in ("plain", "square"))
    assert shown == pytest.approx(plain + 0.1 * plain**2, rel=1e-5)
    assert "force_square" in listed
    assert numbers == "[1]\n"


@pytest.mark.slow
def test_the_quantity_is_traded_off(tmp_path: Path, run: Run) -> None:
    """Against the mass, to which it is proportional: 36 g are printed in 9000 s."""
    quantities = ("--quantity", "mass_g", "--quantity", "print_time_s")
    varied = ("--parameter", "morph.xi1=-0.2:1:4", "--parameter", "morph.xi2=-0.5:1:4")
    mesh = ("--set", "mesh.size_mm=12", "--set", "mesh.edge_size_mm=12")
    senses = ("--against", "print_time_s", "--at-most", "9000", "--maximise", "mass_g")
    small = ("--population", "20", "--generations", "10", "--along", "0")
    run(
        tmp_path, ["doe", *quantities, *varied, *mesh, "--out", "doe"],
        ["train", "doe", "--out", "surrogate", "--epochs", "500"],
        ["optimise", "surrogate", *senses, *small, "--out", "optimum"],
    )  # fmt: skip
    found = json.loads((tmp_path / "optimum" / "optimum.json").read_text(encoding="utf-8"))
    assert [each["name"] for each in found["objectives"]] == ["print_time_s", "mass_g"]
    original = next(each for each in found["designs"] if each["role"] == "original")
    assert original["fem"]["print_time_s"] == pytest.approx(original["fem"]["mass_g"] / 0.004)
    chosen = next(each for each in found["designs"] if each["role"] == "chosen")
    assert chosen["surrogate"]["print_time_s"] <= 9000.0
    assert chosen["fem"]["mass_g"] == pytest.approx(35.0, abs=1.5)
    assert chosen["gain"] == pytest.approx(chosen["fem"]["mass_g"] / original["fem"]["mass_g"] - 1)


def test_the_food_lies_on_the_table(tmp_path: Path, run: Run) -> None:
    code = (
        "from dolfingrip.config import load\n"
        "from dolfingrip.experiments.rigs.food import grasped\n"
        "print(1e3 * grasped(load(None, {'food.kind': 'egg'}).food).body.mass_kg)"
    )
    mass_g = 3.1416 / 6 * 56 * 44 * 44 * 1030e-6
    said, mass = run(tmp_path, ["config", "--set", "food.kind=egg"], then=code)
    assert 'kind = "egg"' in said
    assert float(mass) == pytest.approx(mass_g, rel=0.03)


def test_the_experiment_has_a_command(tmp_path: Path, run: Run) -> None:
    asked = ["stretch", "--rate", "1", "--out", "stretch"]
    shown, said, _ = run(tmp_path, ["--help"], asked)
    assert "Pull the material by a tenth" in shown
    assert "A tenth" in said
    assert len(column(tmp_path / "stretch", "force_N")) == 2


def test_the_result_file_is_on_a_page(tmp_path: Path, run: Run) -> None:
    code = (
        "from dolfingrip.plugins.tally import TallyFile\n"
        "TallyFile(days=(1, 2), printed=(3, 4)).write('tally')"
    )
    run(tmp_path, then=code)
    said, _ = run(tmp_path, ["report", "tally", "--out", "tally.html"])
    assert "report: tally.html" in said
    page = (tmp_path / "tally.html").read_text(encoding="utf-8")
    for text in ("<title>Tally</title>", "<h3>Printed fingers</h3>", "<b>7 fingers</b>"):
        assert text in page
