"""The loop by its commands: a campaign's folder, a surrogate's, an optimum's, a study's."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest
from support import analytic, stand_in
from typer.testing import CliRunner, Result

from dolfingrip.cli import commands as cli
from dolfingrip.cli import loop_commands, surrogate_commands
from dolfingrip.cli.settings import OptimiseSettings
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import campaign, space
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.optimum import study_file
from dolfingrip.files.optimum import OptimumFile
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.interrupts import Interrupted

STUDY = Path(__file__).resolve().parents[2] / "examples" / "paper_study.toml"
INPUTS = ("--input", "morph.xi1", "--input", "morph.xi2")


@pytest.fixture(scope="module")
def doe(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of 40 designs, those above ξ1 = 0.6 failed."""
    folder = tmp_path_factory.mktemp("doe")
    parameters = [space.parse(text) for text in ("morph.xi1=-0.2:1:8", "morph.xi2=-0.5:1:5")]
    points = tuple(space.points(parameters, "grid"))
    plan = Plan(Config(), ("morph.xi1", "morph.xi2"), points, objective=analytic.PATH)
    standing = campaign.run(plan, folder, Where())
    assert (standing.done, standing.failed) == (25, 15)
    return folder


def _call(*arguments: object) -> Result:
    result = CliRunner().invoke(cli.app, [str(each) for each in arguments])
    if isinstance(result.exception, Exception):
        raise result.exception
    return result


@pytest.fixture(scope="module")
def surrogate(doe: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("loop") / "surrogate"
    said = _call("train", doe, "--out", folder, "--epochs", 1000).stdout
    assert "25 designs; 15 failed and 0 incomplete ones left out" in said
    assert "training: 20 designs, MSE" in said
    return folder


def test_training_writes_its_files_and_is_not_done_twice(doe: Path, surrogate: Path) -> None:
    assert {file.name for file in surrogate.iterdir()} == {
        "designs.csv", "fit.png", "learning_curve.csv", "learning_curve.png", "surrogate.json",
        "surrogate.pt",
    }  # fmt: skip
    facts = json.loads((surrogate / "surrogate.json").read_text(encoding="utf-8"))
    assert facts["failed_designs"] == 15
    assert facts["training_mse"] < 1e-3
    before = (surrogate / "surrogate.json").stat().st_mtime_ns
    said = _call("train", doe / "campaign.sqlite", "--out", surrogate, "--epochs", 1000).stdout
    assert "already trained on this table" in said
    assert (surrogate / "surrogate.json").stat().st_mtime_ns == before


@pytest.mark.usefixtures("threads")
def test_optimising_computes_again_and_resumes(
    surrogate: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = tmp_path / "started"
    monkeypatch.setenv("DOLFINGRIP_TEST_LOG", str(log))
    command = ("optimise", surrogate, "--out", tmp_path, "--population", 40, "--generations", 15)
    refused = CliRunner().invoke(cli.app, [*map(str, command)])
    assert "package; allowed: --no-resolve, or --objective" in str(refused.exception)
    assert not log.exists()  # nothing of it has run
    copy = shutil.copytree(surrogate, tmp_path / "copy")
    text = (copy / "surrogate.json").read_text(encoding="utf-8")
    other = "dolfingrip.jobs.work:found"  # any function of this package, in the objective's place
    (copy / "surrogate.json").write_text(text.replace(analytic.PATH, other), encoding="utf-8")
    refused = CliRunner().invoke(cli.app, ["optimise", str(copy), *map(str, command[2:])])
    assert f'objective = "{other}": no objective of this package' in str(refused.exception)
    command = (*command, "--objective", analytic.PATH)
    result = _call(*command, "--at-most", 2.0, "--at-most", 2.2)
    assert result.exit_code == 0
    assert "surrogate on 10 points along the front, force_N: RMS error" in result.stdout
    facts = OptimumFile.read(tmp_path)
    roles = [one.role for one in facts.designs]
    assert roles[:3] == ["chosen", "chosen", "original"]
    original = facts.designs[2]
    assert original.fem == {"cog_offset_mm": 2.8, "force_N": 4.0}
    for one in facts.designs:  # finite elements are the analytic objective here
        xi1, xi2 = one.inputs.values()
        assert one.fem is not None
        assert one.fem["force_N"] == pytest.approx(4 + xi1 - xi2)
        assert one.gain == pytest.approx((xi1 - xi2) / 4)
    assert (tmp_path / "pareto.png").stat().st_size > 20_000
    with (tmp_path / "front.csv").open(encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == len(facts.front)
    started = log.read_text(encoding="utf-8")
    assert len(started.splitlines()) <= len(facts.designs) + 10
    _call(*command, "--at-most", 2.0, "--at-most", 2.2)
    assert log.read_text(encoding="utf-8") == started  # nothing is computed twice
    assert OptimumFile.read(tmp_path) == facts


def test_without_finite_elements_nothing_is_computed(surrogate: Path, tmp_path: Path) -> None:
    options = ("--population", 20, "--generations", 5, "--no-resolve")
    result = _call("optimise", surrogate, "--out", tmp_path, *options, "--at-most", -9)
    assert result.exit_code == 1
    assert "no design of the front has cog_offset_mm at most -9" in result.stdout
    assert {file.name for file in tmp_path.iterdir()} == {
        "front.csv", "optimum.json", "pareto.png",
    }  # fmt: skip


@pytest.mark.usefixtures("threads")
def test_study_writes_its_tables(surrogate: Path, tmp_path: Path) -> None:
    options = ("--population", 20, "--generations", 3, "--generations", 6, "--crossover", 0.9)
    options = (*options, "--mutation", 0.5, "--mutation", 0.1, "--seeds", 2, "--processes", 1)
    result = _call("study", surrogate, "--out", tmp_path, *options, "--at-most", 2.5)
    assert result.exit_code == 0
    assert "4 combinations of 2 seeds, from 4 runs of NSGA-II" in result.stdout
    with (tmp_path / "combinations.csv").open(encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == 4
    with (tmp_path / "best.csv").open(encoding="utf-8") as stream:
        best = list(csv.DictReader(stream))
    assert [row["generations"] for row in best] == ["3", "6"]
    assert all(float(row["morph.xi1_sd"]) >= 0 for row in best)
    assert (tmp_path / "scatter.png").stat().st_size > 20_000


@pytest.mark.usefixtures("threads")
def test_reproduction_is_set_beside_the_paper(surrogate: Path, tmp_path: Path) -> None:
    options = ("--population", 40, "--generations", 15, "--at-most", 2.5, "--at-most", 3)
    options = (*options, "--objective", analytic.PATH)
    _call("optimise", surrogate, "--out", tmp_path, *options)
    published = study_file.read(STUDY).published
    assert published is not None
    table = loop_commands.comparison(OptimumFile.read(tmp_path), published)
    columns = [list(column.cells) for column in table.columns]
    assert columns[0] == ["2.5", "3"]
    assert columns[2] == ["0.236", "0.306"]
    assert columns[-2] == ["–", "–"]  # the analytic objective has no force at 250 kPa
    assert columns[-1] == ["-7.7", "+12.9"]
    told = OptimumFile.read(tmp_path)
    known = [
        each.model_copy(update={"fem": {"force_N at 250 kPa": force}})
        for each, force in zip(told.designs, (2.0, 3.0, 2.5), strict=False)
    ]
    table = loop_commands.comparison(told.model_copy(update={"designs": tuple(known)}), published)
    assert list(table.columns[-2].cells) == ["-20.0", "+20.0"]
    for limit_mm, failed in ((9.0, False), (-9.0, True)):
        small = OptimiseSettings(
            surrogate=surrogate, out=tmp_path / "none", population=20, generations=3,
            resolve=False, at_most=(limit_mm,),
        )  # fmt: skip
        assert loop_commands.run_step(surrogate_commands.optimise, small) is failed


def test_bad_input_is_said_in_one_line(tmp_path: Path) -> None:
    table = stand_in.write_csv(tmp_path / "designs.csv")
    out = tmp_path / "out"
    for arguments, complaint in (
        (
            ("train", tmp_path / "no", *INPUTS, "--output", "force_N"),
            r"no: unknown kind of table; allowed: ",
        ),
        (("train", table, *INPUTS, "--output", "mass_g"), "no column mass_g"),
        (("train", table), "--input, --output: allowed: names of columns"),
        (("optimise", tmp_path), "No such file or directory; allowed: a surrogate"),
        (("study", tmp_path), "No such file or directory; allowed: a surrogate"),
    ):
        with pytest.raises(ConfigError, match=complaint) as caught:
            _call(*arguments, "--out", out)
        assert "\n" not in str(caught.value)
        assert not out.exists()


def test_an_interrupted_step_ends_the_loop() -> None:
    """The steps after it are not begun."""

    def before(asked: None) -> None:
        raise KeyboardInterrupt

    with pytest.raises(Interrupted, match="the same command goes on from there"):
        loop_commands.run_step(before, None)
