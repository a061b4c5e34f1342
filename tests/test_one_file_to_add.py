"""One of each kind of thing is added to a copy of the package, which its own commands then run.

The files in ``tests/additions`` are made up. Each is put in its folder and, where that has an index
by hand, named there in one line; nothing else of the package changes.
"""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import pytest
from support.checkout import needs_checkout

ROOT = Path(__file__).resolve().parents[1]
MADE_UP = Path(__file__).parent / "additions"

pytestmark = needs_checkout


class Addition(NamedTuple):
    """A file and the line that names it.

    Attributes:
        file: in ``tests/additions``.
        folder: of the checkout, that it is put in.
        index: file there that lists names; "" where files are found by themselves.
        behind: name in that list which the new one is put behind.
    """

    file: str
    folder: str
    index: str = ""
    behind: str = ""


ADDITIONS = {
    "a kind of geometry": Addition("block", "dolfingrip/sections/geometry", "index.py", "pneunet"),
    "a strain energy as base law": Addition(
        "stiffening", "dolfingrip/sections/laws", "index.py", "ogden"
    ),
    "an effect": Addition("force_square", "dolfingrip/extensions"),
    "a food": Addition("egg", "dolfingrip/foods", "index.py", "cube"),
    "a quantity of a design": Addition(
        "print_time", "dolfingrip/design/quantities", "index.py", "grasp"
    ),
    "an experiment": Addition("stretch", "dolfingrip/experiments", "index.py", "grasp"),
    "a result file": Addition("tally_file", "dolfingrip/files"),
    "the page of a result file": Addition("tally", "dolfingrip/report/page/results"),
}
MOST_FILES = 2
"""Files that an addition may touch: its own, and the index."""


def lines(folder: Path) -> dict[Path, list[str]]:
    """Lines of all files of Python, by the file."""
    return {
        file.relative_to(folder): file.read_text(encoding="utf-8").splitlines()
        for name in ("dolfingrip", "forms", "meshes")
        for file in (folder / name).rglob("*.py")
    }


def add(addition: Addition, copy: Path) -> None:
    """Add to a copy of the package."""
    folder = copy / addition.folder
    shutil.copy(MADE_UP / f"{addition.file}.py", folder)
    if addition.index:
        index = folder / addition.index
        text = index.read_text(encoding="utf-8")
        line = f'    "{addition.behind}",\n'
        assert text.count(line) == 1
        index.write_text(text.replace(line, f'{line}    "{addition.file}",\n'), encoding="utf-8")


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package with all additions, which takes the place of the checkout's."""
    folder = tmp_path_factory.mktemp("copy")
    for name in ("dolfingrip", "forms", "meshes"):
        shutil.copytree(ROOT / name, folder / name)
    for name in ("forms", "meshes"):  # parts of the package that lie next to it
        (folder / "dolfingrip" / name).symlink_to(folder / name)
    for addition in ADDITIONS.values():
        add(addition, folder)
    return folder


COMMANDS = """
from dolfingrip.cli.app import app
for call in {calls!r}:
    print("$", *call, flush=True)
    assert not app(call, prog_name="dolfingrip", standalone_mode=False), call
"""


def run(copy: Path, *calls: Sequence[str], then: str = "") -> list[str]:
    """What commands of the copy print, one after another in one process; last what code does."""
    code = COMMANDS.format(calls=[list(call) for call in calls])
    said = printed(copy, "-c", f"{code}\nprint('$')\n{then}")
    return [part.partition("\n")[2] for part in f"\n{said}".split("\n$")[1:]]


def printed(copy: Path, *arguments: str) -> str:
    """What Python prints that imports the copy."""
    environment = {**os.environ, "PYTHONPATH": str(copy)}
    ended = subprocess.run(
        [sys.executable, *arguments], cwd=copy, env=environment, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def column(folder: Path, name: str) -> list[float]:
    """Numbers of a run's result."""
    with (folder / "result.csv").open(encoding="utf-8", newline="") as text:
        return [float(row[name]) for row in csv.DictReader(text)]


@pytest.mark.parametrize("what", ADDITIONS)
def test_files_to_touch(what: str, tmp_path: Path) -> None:
    addition = ADDITIONS[what]
    folder = tmp_path / addition.folder
    folder.mkdir(parents=True)
    if addition.index:
        shutil.copy(ROOT / addition.folder / addition.index, folder)
    for name in ("dolfingrip", "forms", "meshes"):
        (tmp_path / name).mkdir(exist_ok=True)
    before = lines(tmp_path)
    add(addition, tmp_path)
    after = lines(tmp_path)
    touched = [file for file in after if after[file] != before.get(file)]
    assert len(touched) <= MOST_FILES
    more = {file: len(after[file]) - len(before[file]) for file in before}
    assert sum(more.values()) == bool(addition.index)
    print(f"{what}: {len(touched)} files")


def test_the_geometry_is_meshed_and_bends(copy: Path) -> None:
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
        copy, ["mesh", *chosen, "--out", "mesh"], ["bend", *chosen, *pressed, "--out", "bend"],
        then=code,
    )  # fmt: skip
    assert "cavity" in meshed
    assert "Free bending" in bent
    assert abs(column(copy / "bend", "angle_deg")[-1]) > 0.01
    assert told.startswith("4.5 ")
    assert "block.floor_mm" in told


def test_the_law_pulls_and_is_fitted(copy: Path) -> None:
    pull = ("--set", "coupon.max_strain=0.5", "--set", "coupon.step_strain=0.5",
            "--set", "material.bulk_MPa=1000", "--set", "material.law=stiffening")  # fmt: skip
    readings = ROOT / "examples" / "coupons" / "ecoflex30_uniaxial.csv"
    fit = ["coupon", "--fit", str(readings), "--law", "stiffening", "--max-stretch", "2.5"]
    _, said, _ = run(copy, ["coupon", *pull, "--out", "coupon"], [*fit, "--out", "fit"])
    stretch = 1.5
    i = stretch**2 + 2 / stretch - 3
    expected = (stretch - stretch**-2) * (1 + 2 * 0.1 * i)
    assert column(copy / "coupon", "nominal_stress_MPa")[-1] == pytest.approx(expected, rel=1e-3)
    assert "Stiffening" in said
    assert 'law = "stiffening"' in (copy / "fit" / "material.toml").read_text(encoding="utf-8")


def test_the_effect_is_displayed_and_tried(copy: Path) -> None:
    pull = ("--set", "coupon.max_strain=0.1", "--set", "coupon.step_strain=0.1")
    square = ("--set", "extensions.force_square.square_per_N=0.1")
    code = (
        "from dolfingrip.config import Config\n"
        "from dolfingrip.diagnosis.core.unknown import causes\n"
        "print([len(e.numbers) for e in causes(Config(), ['force_square'])])"
    )
    *_, listed, numbers = run(
        copy, ["coupon", *pull, "--out", "plain"], ["coupon", *pull, *square, "--out", "square"],
        ["extensions"], then=code,
    )  # fmt: skip
    plain, shown = (column(copy / name, "force_N")[-1] for name in ("plain", "square"))
    assert shown == pytest.approx(plain + 0.1 * plain**2, rel=1e-5)
    assert "force_square" in listed
    assert numbers == "[1]\n"


@pytest.mark.slow
def test_the_quantity_is_traded_off(copy: Path) -> None:
    """Against the mass, to which it is proportional: 36 g are printed in 9000 s."""
    quantities = ("--quantity", "mass_g", "--quantity", "print_time_s")
    varied = ("--parameter", "morph.xi1=-0.2:1:4", "--parameter", "morph.xi2=-0.5:1:4")
    mesh = ("--set", "mesh.size_mm=12", "--set", "mesh.edge_size_mm=12")
    senses = ("--against", "print_time_s", "--at-most", "9000", "--maximise", "mass_g")
    small = ("--population", "20", "--generations", "10", "--along", "0")
    run(
        copy, ["doe", *quantities, *varied, *mesh, "--out", "doe"],
        ["train", "doe", "--out", "surrogate", "--epochs", "500"],
        ["optimise", "surrogate", *senses, *small, "--out", "optimum"],
    )  # fmt: skip
    found = json.loads((copy / "optimum" / "optimum.json").read_text(encoding="utf-8"))
    assert [each["name"] for each in found["objectives"]] == ["print_time_s", "mass_g"]
    original = next(each for each in found["designs"] if each["role"] == "original")
    assert original["fem"]["print_time_s"] == pytest.approx(original["fem"]["mass_g"] / 0.004)
    chosen = next(each for each in found["designs"] if each["role"] == "chosen")
    assert chosen["surrogate"]["print_time_s"] <= 9000.0
    assert chosen["fem"]["mass_g"] == pytest.approx(35.0, abs=1.5)
    assert chosen["gain"] == pytest.approx(chosen["fem"]["mass_g"] / original["fem"]["mass_g"] - 1)


def test_the_food_lies_on_the_table(copy: Path) -> None:
    code = (
        "from dolfingrip.config import load\n"
        "from dolfingrip.experiments.rigs.food import grasped\n"
        "print(1e3 * grasped(load(None, {'food.kind': 'egg'}).food).body.mass_kg)"
    )
    mass_g = 3.1416 / 6 * 56 * 44 * 44 * 1030e-6
    said, mass = run(copy, ["config", "--set", "food.kind=egg"], then=code)
    assert 'kind = "egg"' in said
    assert float(mass) == pytest.approx(mass_g, rel=0.03)


def test_the_experiment_has_a_command(copy: Path) -> None:
    asked = ["stretch", "--rate", "1", "--out", "stretch"]
    shown, said, _ = run(copy, ["--help"], asked)
    assert "Pull the material by a tenth" in shown
    assert "A tenth" in said
    assert len(column(copy / "stretch", "force_N")) == 2


def test_the_result_file_is_on_a_page(copy: Path) -> None:
    code = (
        "from dolfingrip.files.tally_file import TallyFile\n"
        "TallyFile(days=(1, 2), printed=(3, 4)).write('tally')"
    )
    run(copy, then=code)
    said, _ = run(copy, ["report", "tally", "--out", "tally.html"])
    assert "report: tally.html" in said
    page = (copy / "tally.html").read_text(encoding="utf-8")
    for text in ("<title>Tally</title>", "<h3>Printed fingers</h3>", "<b>7 fingers</b>"):
        assert text in page
