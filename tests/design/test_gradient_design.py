"""Designs by gradients: the problem file, limits that hold, steps that improve, resumption.

The descent itself is tested on invented answers, whose optimum is known; what finite elements
answer is compared with differences of whole runs.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Generator, Sequence
from pathlib import Path

import numpy as np
import pytest
from support.example import EXAMPLES
from support.invented import COG, FORCE, TWO, Invented, written
from typer.testing import CliRunner

from dolfingrip import config as configuration
from dolfingrip.cli.commands import app
from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.design.gradient import starts
from dolfingrip.design.gradient.descent import DescentPolicy, NoStart, Trial, TrustRegionSQP
from dolfingrip.design.gradient.evaluation import DesignSimulations
from dolfingrip.design.gradient.file import CELL_QUALITY, FACING
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.gradient.read import read
from dolfingrip.design.gradient.shape import UnloadedShapes
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.simulate import computed_in
from dolfingrip.jobs.job import Job, JobResult
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.work import work

# -- bad input -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            FORCE.replace("force_N", "fours_N") + TWO,
            "objective.maximise = fours_N: allowed: angle_deg, ",
        ),
        (FORCE.replace("at_p", "# at_p") + TWO, "objective.maximise = force_N: 0 places; allowed"),
        (FORCE + 'minimise = "mass_g"\n' + TWO, "objective: 2 quantities; allowed: one of"),
        (FORCE.replace("force_N", "pickup_pressure_kPa") + TWO, "no gradient: a grasp with frict"),
        (
            FORCE.replace("force_N", "pickup_margin") + TWO,
            "allowed: the objective, without a place",
        ),
        ('[objective]\nmaximise = "least_wall_mm"\n' + TWO, "an extreme over the shape"),
        (FORCE, "parameters: none; allowed"),
        (FORCE + "[parameters]\nmorph.xi1 = [0.5, 0.1]\n", "xi1 = [0.5, 0.1]: allowed: low below"),
        (FORCE + "[parameters]\nmorph.xi1 = [-3.0, 0.1]\n", "parameters morph.xi1 = -3"),
        (FORCE + "[parameters]\nfinger.walls_mm = [1.0, 2.0]\n", "parameters.finger.walls_mm"),
        (
            FORCE + "[parameters]\nmorph.xi1 = {from = -0.1, to = 0.3, start = 0.5}\n",
            "morph.xi1: start = 0.5: allowed: -0.1 to 0.3",
        ),
        (
            FORCE + '[[constraints]]\nof = "mass_g"\nat_most = 3.0\nat_least = 5.0\n' + TWO,
            "at_least = 5 above at_most = 3",
        ),
        (FORCE + COG.replace('at_most = "start"', "") + TWO, "with at_most or at_least"),
        (FORCE + TWO + "[methods]\nsimulations = 3\n", "methods: unknown key"),
        (FORCE + TWO + "[method]\nsimulations = 0\n", "method.simulations = 0: allowed"),
    ],
)
def test_bad_input_gets_one_line(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        read(written(tmp_path, text))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_memory_effect_is_refused(tmp_path: Path) -> None:
    file = written(tmp_path, FORCE + TWO, "extensions.prony={}")
    with pytest.raises(ConfigError, match=r"extensions\.prony: remembers earlier states"):
        read(file)


def test_limits_that_no_design_keeps(tmp_path: Path) -> None:
    text = FORCE + '[[constraints]]\nof = "cog_offset_mm"\nat_most = -4.0\n' + TWO
    problem = read(written(tmp_path, text))
    with pytest.raises(NoStart, match=r"cog_offset_mm at most -4: .* at the nearest design"):
        TrustRegionSQP(problem, DesignSimulations(problem, Invented())).run()


# -- the descent, on invented answers ------------------------------------------------------------


def descended(file: Path, answer: Invented) -> tuple[Problem, list[Trial], Trial, str]:
    problem = read(file)
    found = TrustRegionSQP(problem, DesignSimulations(problem, answer)).run()
    assert found.simulations == len(answer.asked)
    taken = [each.objective for each in found.trials if each.accepted]
    assert all(np.diff(taken) * -problem.sign > 0), "an accepted step did not improve"
    return problem, found.trials, found.best, found.ending


def test_a_free_optimum_is_found(tmp_path: Path) -> None:
    file = written(tmp_path, FORCE + TWO)
    _, trials, best, ending = descended(file, Invented())
    assert ending == "no step promises more"
    assert len(trials) <= 20
    assert best.objective == pytest.approx(3.0, abs=3e-3)


def test_limits_of_shape_and_of_simulations_hold(tmp_path: Path) -> None:
    angle = '[[constraints]]\nof = "angle_deg"\nat_pressure_kPa = 50.0\nat_least = 35.0\n'
    wall = '[[constraints]]\nof = "least_wall_mm"\nat_least = 1.45\n'
    file = written(tmp_path, FORCE + COG + angle + wall + TWO)
    problem, trials, best, _ = descended(file, Invented())
    limits = {each.quantity.name: i for i, each in enumerate(problem.limits)}
    for each in trials:  # of the shape: in every design that was simulated
        assert each.limits[limits["least_wall_mm"]] >= 1.45 * (1 - DescentPolicy().kept)
        most = trials[0].limits[limits["cog_offset_mm"]]
        assert each.limits[limits["cog_offset_mm"]] <= most * (1 + DescentPolicy().kept)
    assert best.limits[limits["angle_deg"]] >= 35.0 * (1 - DescentPolicy().broken)
    assert best.objective > trials[0].objective


def test_a_failed_solve_is_a_shorter_step(tmp_path: Path) -> None:
    """Designs beyond ξ1 = 0.2 have no solution: it ends just before."""
    file = written(tmp_path, FORCE + TWO)
    _, trials, best, _ = descended(file, Invented(lambda config: config.morph.xi1 > 0.2))
    failed = [each for each in trials if each.failure]
    assert failed
    assert failed[0].failure == "limit point: invented"
    assert 0.1 < best.values[0] <= 0.2


def test_steps_that_all_fail_do_not_tell_an_optimum(tmp_path: Path) -> None:
    problem = read(written(tmp_path, FORCE + TWO))

    def elsewhere(config: Config) -> bool:
        return (config.morph.xi1, config.morph.xi2) != (0.0, 0.0)

    found = TrustRegionSQP(problem, DesignSimulations(problem, Invented(elsewhere))).run()
    assert found.ending == "not known whether a step improves: it fails (limit point: invented)"


def test_a_start_that_fails_is_told(tmp_path: Path) -> None:
    problem = read(written(tmp_path, FORCE + TWO))
    with pytest.raises(NoStart, match=r"^the start cannot be simulated: limit point: invented$"):
        TrustRegionSQP(problem, DesignSimulations(problem, Invented(lambda config: True))).run()


def test_the_worst_scenario_counts(tmp_path: Path) -> None:
    """With ξ1 moved by ±0.1 the best of the worst is where both are equal."""
    both = '[[scenarios]]\nchange = ["morph.xi1=0.1"]\n[[scenarios]]\nchange = ["morph.xi1=-0.1"]\n'
    problem, trials, best, _ = descended(written(tmp_path, FORCE + TWO + both), Invented())
    assert len(problem.conditions) == 3
    config = problem.nominal.config(problem.variables, best.values.tolist())
    moved = [changed(config, {"morph.xi1": best.values[0] + by}) for by in (0.0, 0.1, -0.1)]
    assert best.objective == pytest.approx(min(map(Invented.force_N, moved)), rel=1e-9)
    assert best.objective > trials[0].objective


def test_several_starts_and_what_differs(tmp_path: Path) -> None:
    """One optimum: nothing differs. Two of equal height, at ξ1 = ±0.1 (mirrored): ξ1 differs."""
    text = FORCE + TWO + "[method]\nsimulations = 30\nstarts = 4\n"
    problem = read(written(tmp_path, text))
    said: list[Trial] = []
    found = starts.solve(problem, Invented(), lambda trial, limits: said.append(trial))
    assert len(found.descents) == len(starts.begins(problem)) == 4
    told = found.facts(problem)
    assert told["differ"] == {}
    assert all(each["as_good"] for each in told["starts"])
    assert len({each["start"] for each in told["starts"]}) == 4
    assert sum(each["simulations"] for each in told["starts"]) == len(said)
    problem = read(written(tmp_path, text.replace("1.0]", "0.2]")))
    found = starts.solve(problem, Twice(), lambda trial, limits: None)
    low, high = found.facts(problem)["differ"]["morph.xi1"]
    assert (low, high) == pytest.approx((-0.1, 0.1), abs=0.015)


class Twice(Invented):
    """Two best designs."""

    @staticmethod
    def force_N(config: Config) -> float:
        """Largest at ξ = (±0.1, 0)."""
        return 3.0 - 1000 * (config.morph.xi1**2 - 0.01) ** 2 - config.morph.xi2**2


# -- the shape -----------------------------------------------------------------------------------


def test_slopes_of_the_shape(tmp_path: Path) -> None:
    """Mass, COG offset, walls, gaps and overhangs of a bent finger along a random direction."""
    text = FORCE + TWO + "[parameters.finger]\nwall_mm = [1.0, 2.0]\n[free_form]\nmost_mm = 0.4\n"
    problem = read(written(tmp_path, text))
    shapes = UnloadedShapes(problem)
    rng = np.random.default_rng(7)
    low = np.array([each.low for each in problem.variables])
    high = np.array([each.high for each in problem.variables])
    starts = np.array([each.start for each in problem.variables])
    assert len(starts) > 100
    at = starts + 0.1 * rng.uniform(-1, 1, len(starts)) * (high - low)
    along, step = rng.uniform(-1, 1, len(starts)) * (high - low), 1e-5
    here = shapes.at(at)
    ahead, back = shapes.at(at + step * along), shapes.at(at - step * along)
    for name in ("mass_g", "cog_offset_mm"):
        expected = (ahead.value(name) - back.value(name)) / (2 * step)
        assert here.gradient(name) @ along == pytest.approx(expected, rel=1e-6), name
    for name in (*FACING, "overhang_deg", CELL_QUALITY):
        rows = here.rows(name)
        chosen = np.flatnonzero(rows > 1e-3)[:40]
        expected = ((ahead.rows(name) - back.rows(name)) / (2 * step))[chosen]
        slopes = along @ here.row_gradients(name, chosen)
        np.testing.assert_allclose(slopes, expected, rtol=1e-5, atol=1e-6, err_msg=name)


def test_a_cell_that_becomes_a_sheet_is_worse(tmp_path: Path) -> None:
    """Its edges keep their directions, but one is 3 % as long: twice that counts."""
    text = FORCE + "[parameters.finger]\nwall_mm = [0.02, 2.0]\n"
    shapes = UnloadedShapes(read(written(tmp_path, text)))
    start = float(shapes.variables[0].start)
    assert shapes.at([0.7 * start]).value(CELL_QUALITY) == pytest.approx(1.0, abs=0.1)
    thin = shapes.at([0.03 * start])
    assert thin.value(CELL_QUALITY) == pytest.approx(0.06, rel=1e-6)
    worst = np.argsort(thin.rows(CELL_QUALITY))[:10]
    ahead, back = (shapes.at([0.03 * start + by * 1e-5]).rows(CELL_QUALITY) for by in (1, -1))
    slopes = thin.row_gradients(CELL_QUALITY, worst)[0]
    np.testing.assert_allclose(slopes, ((ahead - back) / 2e-5)[worst], rtol=1e-6)


# -- a free form

TUBE = (EXAMPLES / "tube_design.toml").read_text(encoding="utf-8")


def tube(folder: Path, text: str) -> Problem:
    file = folder / "tube.toml"
    file.write_text(text, encoding="utf-8")
    return read(file)


def test_a_rippled_tube(tmp_path: Path) -> None:
    """Waves of the roof, a straight back, ends that stay, outer faces within their bounds."""
    problem = tube(tmp_path, TUBE)
    shape = UnloadedShapes(problem).at([each.start for each in problem.variables])
    points = shape.mesh.points
    roof = points[np.isclose(points[:, 1], 0) & (points[:, 0] > 15)]
    inner = roof[(roof[:, 2] > 6) & (roof[:, 2] < 74)]
    waves = np.cos(2 * np.pi * inner[:, 2] / 10.0)
    assert np.corrcoef(waves, inner[:, 0])[0, 1] > 0.9
    assert np.ptp(inner[:, 0]) == pytest.approx(2 * 0.32, rel=0.4)
    assert points[:, 0].min() == 0.0
    for end in (0.0, 80.0):
        outline = points[np.isclose(points[:, 2], end)]
        assert (outline[:, 0].max(), outline[:, 1].max()) == pytest.approx((16.0, 8.0))
    ends = {(each.low, each.high) for each in problem.variables}
    assert ends == {(-7.0, 7.0), (-7.0, 4.0)}
    every = np.where([each.high == 4.0 for each in problem.variables], 4.0, 0.0)
    grown = UnloadedShapes(problem).at(every).mesh.points
    assert (grown[:, 0].max(), grown[:, 1].max()) == pytest.approx((20.0, 12.0), abs=1e-9)
    assert shape.value("least_gap_mm") == np.inf  # a tube has no gaps
    # limits look at cells that are divided in two along each axis, at their eight corners and the
    # three edges of each
    assert len(shape.rows(CELL_QUALITY)) == 4 * 8 * 8 * len(shape.mesh.cells)


def test_a_ripple_beyond_its_bounds(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"free_form: start = .* allowed: -0\.1 to 0\.1 mm"):
        tube(tmp_path, TUBE.replace("most_mm = 7.0", "most_mm = 0.1"))
    form = f'"form.along=3", "form.offsets_mm={[0.0] * 38}"'
    with pytest.raises(ConfigError, match=r"free_form\.ripple_mm = 0\.32: allowed: without"):
        tube(tmp_path, TUBE.replace('"experiment.step_kPa=10"', form))


# -- runs


class Here:
    """Workers' answers in this process, until it is killed.

    Args:
        killed_after: number of jobs.
    """

    def __init__(self, killed_after: int = 99) -> None:
        self.computed = 0
        self._killed_after = killed_after

    def answers(self, jobs: Sequence[Job], spool: Spool) -> Generator[JobResult]:
        for job in jobs:
            if self.computed == self._killed_after:
                raise KeyboardInterrupt
            self.computed += 1
            yield work(job, spool.folder)


def test_a_killed_run_goes_on(tmp_path: Path) -> None:
    """On finite elements: what was computed is not computed again, and the result is the same."""
    file = written(tmp_path, FORCE + COG + TWO + "[method]\nsimulations = 4\n")
    problem = read(file)

    def solved(folder: Path, pool: Here) -> Trial:
        compute = computed_in(folder, pool)  # type: ignore[arg-type]
        return TrustRegionSQP(problem, DesignSimulations(problem, compute)).run().best

    with pytest.raises(KeyboardInterrupt):
        solved(tmp_path / "jobs", Here(killed_after=2))
    again = Here()
    best = solved(tmp_path / "jobs", again)
    whole = Here()
    assert solved(tmp_path / "whole", whole).objective == pytest.approx(best.objective, rel=1e-9)
    assert again.computed == whole.computed - 2
    assert best.limits[0] <= problem_start(problem) * (1 + DescentPolicy().kept)


def problem_start(problem: Problem) -> float:
    """COG offset of the start (mm)."""
    return (
        UnloadedShapes(problem)
        .at([each.start for each in problem.variables])
        .value("cog_offset_mm")
    )


@pytest.mark.slow
def test_command(tmp_path: Path) -> None:
    file = written(tmp_path, FORCE + COG + TWO + "[method]\nsimulations = 3\n")
    options = ["--out", str(tmp_path / "out"), "--no-refine"]
    done = CliRunner().invoke(app, ["design", str(file), *options])
    assert done.exit_code == 0, done.output
    told = json.loads((tmp_path / "out" / "design.json").read_text(encoding="utf-8"))
    assert told["simulations"] <= 3
    assert told["objective"] > told["start"]
    assert told["constraints"][0]["kept"]
    assert set(told["parameters"]) == {"morph.xi1", "morph.xi2"}
    found = configuration.load(tmp_path / "out" / "design.toml")
    assert found.morph.xi1 == told["parameters"]["morph.xi1"]["value"]
    for name, value in (("start", told["start"]), ("design", told["objective"])):
        run = Result.read(tmp_path / "out" / name)
        assert run.column("pressure_kPa")[-1] == 50.0
        assert run.column("force_N")[-1] == pytest.approx(value, rel=1e-6)
        assert (tmp_path / "out" / name / "fields.pvd").is_file()
    names = {each.name for each in (tmp_path / "out").iterdir()}
    assert {"finger.png", "section.png", "convergence.png", "finger.stl", "steps.csv"} <= names
    assert "█" in done.output
    with (tmp_path / "out" / "steps.csv").open(encoding="utf-8") as file:
        taken = [row for row in csv.DictReader(file) if row["accepted"] == "True"]
    pictures = sorted(each.name for each in (tmp_path / "out" / "steps").iterdir())
    assert pictures == [f"{int(each['simulations']):03d}.png" for each in taken]
    assert all(each in done.output for each in pictures)
