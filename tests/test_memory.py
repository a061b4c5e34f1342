"""Runs give their memory back: no model outlives its run, and ten runs take no more than three."""

from __future__ import annotations

import gc
import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path

import pytest
from mpi4py import MPI
from support import small

from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.experiments import run
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.request import Place, Request
from dolfingrip.experiments.results.readings import Row
from dolfingrip.experiments.simulate import compute
from dolfingrip.jobs.cluster import Where
from dolfingrip.mechanics.model.model import Model

RUNS = 10
DESIGNS = 6
FIRST = 3
"""The run from which on memory is counted: earlier ones load compiled forms."""

MOST_MB = 2.0
"""Largest growth for each run. A model of these meshes, with its factors, takes 3 MB or more."""

STUMP = (
    "finger.bellows=1",
    "finger.length_mm=26",
    "mesh.size_mm=20",
    "mesh.edge_size_mm=20",
    "experiment.max_pressure_kPa=20",
    "experiment.step_kPa=20",
)
"""A finger of one bellows: a run takes a fifth of a second."""

GRASP = (
    "food.width_mm=14",
    "food.length_mm=30",
    "food.height_mm=24",
    "food.friction=0.5",
    "gripper.half=true",
    "gripper.clearance_mm=4",
    "gripper.pressurise_s=0.2",
    "gripper.settle_s=0.1",
    "gripper.lift_mm=0.2",
    "gripper.step_s=0.4",
)
PARAMETERS = ("material.mu_MPa", "finger.wall_mm")
NAME = "bending"

Work = Callable[[Path], object]


def experiment(name: str, *overrides: str, gradients: tuple[str, ...] | None = None) -> Work:
    """A run that ends as it should, without files."""

    def work(folder: Path) -> None:
        config = small.short(*STUMP, *overrides)
        assert run(name, config, comm=MPI.COMM_SELF, gradients=gradients).failure is None

    return work


def failing(folder: Path) -> None:
    """A run whose solver has too few iterations."""
    hard = ("solver.rtol=1e-12", "solver.max_iterations=1", "solver.min_step_kPa=10")
    config = small.short(*STUMP, *hard)
    assert run(NAME, config, comm=MPI.COMM_SELF).failure is not None


def raising(folder: Path) -> None:
    """A run with files that an error in a caller's function ends."""

    def progress(row: Row) -> None:
        raise RuntimeError

    with suppress(RuntimeError):
        run(NAME, small.short(*STUMP), out=folder, comm=MPI.COMM_SELF, progress=progress)
        raise AssertionError


def designed(folder: Path) -> None:
    """A request of a design by gradients, and one whose place is not reached."""
    config, columns = small.short(*STUMP), ("force_N", "angle_deg")
    wanted = ((PARAMETERS, Place("pressure_kPa", 20.0)), (None, Place("force_N", 99.0)))
    for gradients, place in wanted:
        asked = Request.of("blocked_force", config, gradients, columns=columns, places=(place,))
        found = compute(asked, MPI.COMM_SELF)
        assert bool(found.slopes) is (gradients is not None)
        assert (found.failure is None) is (gradients is not None)


def explored(folder: Path) -> None:
    """The request of the explorer's worker."""
    found = compute(Request.of(NAME, small.short(*STUMP), fields=folder), MPI.COMM_SELF)
    assert found.failure is None


WORKS: Mapping[str, Work] = {
    **{name: experiment(name) for name in EXPERIMENTS},
    "grasp": experiment("grasp", *GRASP),
    "gradients": experiment(NAME, gradients=PARAMETERS),
    "failing": failing,
    "raising": raising,
    "designed": designed,
    "explored": explored,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", WORKS)
def test_ten_runs_take_no_more_memory_than_three(name: str, tmp_path: Path) -> None:
    """Models are freed with the last reference to them, without a search for cycles."""
    before = models()
    memory_MB = []
    for _ in range(RUNS):
        WORKS[name](tmp_path)
        memory_MB.append(resident_MB())
        assert not left(before)
    print("memory (MB)", [round(each, 1) for each in memory_MB])
    assert (memory_MB[-1] - memory_MB[FIRST - 1]) / (RUNS - FIRST) < MOST_MB


@pytest.mark.parametrize("solver", ["linear=iterative", "element=P2-P1"])
def test_other_solvers_free_their_models(solver: str, tmp_path: Path) -> None:
    before = models()
    experiment(NAME, f"solver.{solver}")(tmp_path)
    assert not left(before)


def models() -> list[Model]:
    """All models that are alive."""
    return [found for found in gc.get_objects() if type(found) is Model]


def left(before: list[Model]) -> list[Model]:
    """The models that are alive and not among earlier ones."""
    return [model for model in models() if not any(model is old for old in before)]


def resident_MB() -> float:
    """Memory of this process (10⁶ bytes)."""
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()
    return int(pages[1]) * 4096 / 1e6


def test_a_campaigns_last_design_has_the_peak_of_its_first(tmp_path: Path) -> None:
    """On one worker, by the ``run.json`` of designs that differ in their shape."""
    out = tmp_path / "fields"
    points = tuple({"morph.xi1": 0.02 * i} for i in range(DESIGNS))
    plan = Plan(small.short(*STUMP), ("morph.xi1",), points, ("force_N",), fields=out)
    assert campaign.run(plan, tmp_path / "doe", Where(workers=1)).done == DESIGNS
    rows = sorted(campaign.read(tmp_path / "doe").designs, key=lambda row: str(row.started_at))
    peaks = [
        json.loads((out / row.key / "blocked_force" / "run.json").read_text(encoding="utf-8"))[
            "peak_memory_MB"
        ]
        for row in rows
    ]
    print("peaks (MB)", peaks)
    assert peaks[-1] == pytest.approx(peaks[0], rel=0.02)
