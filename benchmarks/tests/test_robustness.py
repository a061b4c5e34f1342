"""The robustness table around its runs: what is drawn, and what is written; nothing is solved."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from benchmarks import robustness
from dolfingrip import config
from dolfingrip.config import Config
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.jobs.job import JobResult
from dolfingrip.jobs.store import Store

SEED = 4


@pytest.fixture(scope="module")
def shared() -> Config:
    """Settings that all fingers share."""
    return robustness.base()


@pytest.fixture(scope="module")
def points(shared: Config) -> list[Inputs]:
    """Some fingers."""
    print("seed", SEED)
    return robustness.draw(30, SEED, shared)


def test_fingers_are_within_their_ranges(points: list[Inputs], shared: Config) -> None:
    """Each is a valid configuration with clear chambers, and bounds are not exceeded."""
    for point in points:
        for key, (low, high) in robustness.RANGES.items():
            assert low <= point[key] <= high
        settings = config.from_dict(robustness.design_of(point, shared).config)
        finger = settings.finger
        assert finger.bellows_mm - 2 * finger.wall_mm >= robustness.CLEAR_MM
        assert settings.mesh.size_mm <= robustness.LARGEST_MM
        assert settings.solver.element == "P2-P1"
        assert settings.experiment.max_pressure_kPa == 300
    for key, (low, high) in robustness.RANGES.items():  # the ranges are made use of
        values = [point[key] for point in points]
        assert max(values) - min(values) > 0.6 * (high - low), key


def test_a_longer_table_contains_the_shorter(points: list[Inputs], shared: Config) -> None:
    """Which is what makes an extension cheap; another seed gives other fingers."""
    assert robustness.draw(5, SEED, shared) == points[:5]
    assert not [p for p in robustness.draw(5, SEED + 1, shared) if p in points]


def test_impossible_fingers_are_left_out(points: list[Inputs], shared: Config) -> None:
    """Fingers that the configuration refuses, and chambers of less than a millimetre."""
    possible = {**points[0], "finger.bellows": 4, "finger.gap_mm": 1.0}
    assert robustness.possible(possible, shared)
    assert not robustness.possible({**possible, "finger.wall_mm": 20.0}, shared)
    finger = config.from_dict(robustness.design_of(possible, shared).config).finger
    most = finger.pitch_mm - 2 * finger.wall_mm - robustness.CLEAR_MM
    assert robustness.possible({**possible, "finger.gap_mm": round(most - 0.01, 3)}, shared)
    assert not robustness.possible({**possible, "finger.gap_mm": round(most + 0.01, 3)}, shared)


def test_table_and_failures(points: list[Inputs], shared: Config, tmp_path: Path) -> None:
    """Ends by kind; what stopped early has a configuration that is the finger's own."""
    few = points[:3]
    ends = {
        "free": [None, "limit point", "contact"],
        "blocked": [None, None, None],
    }
    for run, (quantity, _) in robustness.RUNS.items():
        plan = robustness.plan(run, few, shared)
        with Store(tmp_path / run, write=True) as store:
            store.add(plan.jobs(), plan.shared)
            for design, end in zip(plan.designs(), ends[run], strict=True):
                answer = JobResult(design.key, "failed" if end else "done", wall_s=1.0)
                if end:
                    answer.failure_class = end
                    answer.failure = f"stopped at 120 kPa ({end}): as it is"
                else:
                    answer.result = {"outputs": {quantity: 1.5}, "iterations": 7}
                assert store.record(answer)
    rows = robustness.outcomes(tmp_path, few, shared)
    assert [row["free_end"] for row in rows] == ["reached", "limit point", "contact"]
    assert rows[0]["blocked_force_N"] == 1.5
    said = robustness.summary(rows, SEED)
    assert f"3 random fingers of seed {SEED}" in said
    assert "| contact | 1 | 0 |" in said
    assert "5 of 6 runs (83.3%)" in said

    robustness.write_table(rows, tmp_path / "outcomes.csv")
    with (tmp_path / "outcomes.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 3
    written = robustness.write_failures(rows, shared, tmp_path / "failures")
    assert [path.name for path in written] == ["001_free.toml", "002_free.toml"]
    first, second, *_ = written[0].read_text(encoding="utf-8").splitlines()
    assert first == f"# scripts/run dolfingrip bend --config {written[0]}"
    assert second == "# limit point: stopped at 120 kPa (limit point): as it is"
    settings = config.load(written[0])
    assert settings.model_dump(mode="json") == robustness.design_of(few[1], shared).config
