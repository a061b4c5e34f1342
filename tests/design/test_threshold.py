"""The least value at which something succeeds, and the searches made of it, by made-up grasps."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from support.invented_grasp import grasp, grasps, least_kPa, lifts

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import pickup
from dolfingrip.design.campaign.pickup import GraspTrials, Threshold, least
from dolfingrip.experiments import simulate
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import Compute
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool, Unfinished
from dolfingrip.jobs.store import NAME

SEED = 7


def test_least_at_random() -> None:
    """Against a scan of the whole grid; few trials where the start is near."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    for _ in range(200):
        low, high = 1, int(rng.integers(2, 80))
        edge, start = int(rng.integers(0, 90)), int(rng.integers(-5, 95))
        tried: list[int] = []

        def passes(place: int, edge: int = edge, tried: list[int] = tried) -> bool:
            tried.append(place)
            return place >= edge

        found = least(passes, start, low, high)
        good = [place for place in range(low, high + 1) if place >= edge]
        bad = [place for place in range(low, high + 1) if place < edge]
        assert found == Threshold(bad[-1] if bad else None, good[0] if good else None)
        assert len(tried) <= 2 + 2 * np.log2(high + 1)
        if start in (edge, edge - 1) and low < edge <= high:
            assert len(tried) <= 2


@pytest.mark.parametrize("mu", [0.2, 0.38, 0.7])
@pytest.mark.parametrize("start", [60.0, 150.0, 300.0])
def test_pickup_pressure(mu: float, start: float) -> None:
    base = Config().changed(food={"friction": mu})
    trials = GraspTrials(base, grasps)
    found = pickup.pickup_pressure(trials, 5.0, start)
    exact = least_kPa(mu)
    if exact > 300:
        assert found.least_kPa is None
        return
    assert found.fails_kPa is not None
    assert found.least_kPa is not None
    assert found.fails_kPa < exact <= found.least_kPa
    assert found.least_kPa - found.fails_kPa == pytest.approx(5.0)
    assert len(trials.made) <= 9


@pytest.mark.parametrize("mu", [0.2, 0.38, 0.7])
@pytest.mark.parametrize("tolerance", [0.002, 0.01])
def test_calibration_recovers_friction(mu: float, tolerance: float) -> None:
    """Both ends to the step: with the low one the pressure lifts, with one step less it does not;
    with the high one the next lower pressure does not lift, with one step more it does."""
    measured = 5 * np.ceil(least_kPa(mu) / 5)
    trials = GraspTrials(Config(), grasps)
    found = pickup.friction(trials, measured, 5.0, tolerance)
    assert lifts(found.low, measured)
    assert not lifts(found.low - tolerance, measured)
    assert not lifts(found.high, measured - 5.0)
    assert lifts(found.high + tolerance, measured - 5.0)
    assert found.low - tolerance <= mu <= found.high + tolerance
    assert found.friction == pytest.approx(mu, abs=0.02)


@pytest.mark.usefixtures("threads")
def test_a_search_goes_on_where_it_was_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is stored is not computed again; a damaged answer is none."""
    computed: list[str] = []

    def counted(request: Request, comm: object = None) -> Answer:
        computed.append(request.key)
        return grasp(request.config)

    monkeypatch.setattr(simulate, "compute", counted)
    with Pool(Where()) as pool:
        compute = simulate.computed_in(tmp_path, pool)
        first = GraspTrials(Config(), compute)
        found = pickup.pickup_pressure(first, 5.0, 100.0)
        assert len(computed) == len(set(computed)) == len(first.made)
        with closing(sqlite3.connect(tmp_path / NAME)) as base, base:
            base.execute("UPDATE jobs SET result = '{' WHERE key = ?", (computed[0],))
        again = GraspTrials(Config(), compute)
        assert pickup.pickup_pressure(again, 5.0, 100.0) == found
    assert computed[len(first.made) :] == [computed[0]]


@pytest.mark.parametrize(
    ("pressure", "resolution", "said"),
    [
        (20.0, 5.0, "--pickup-pressure 20: .* gripper.clearance_mm = 42 mm"),
        (155.0, 150.0, "--resolution 150: .* at 5 kPa, so μ is 0.4 or any above"),
    ],
)
def test_no_friction_will_do(pressure: float, resolution: float, said: str) -> None:
    """The option is named that was typed: the pressure, or the step to one that never lifts."""
    trials = GraspTrials(Config(), grasps)
    with pytest.raises(ConfigError, match=said) as error:
        pickup.friction(trials, pressure, resolution, 0.05)
    assert "no friction up to 2 picks the food up" in str(error.value)


def ended(config: Config, kind: str) -> Answer:
    """A grasp that ended in its first step, before its class was decided."""
    return Answer(failure_class=kind, failure=f"invented at {config.experiment.max_pressure_kPa:g}")


def some_end(beyond_kPa: float) -> Compute:
    """Grasps up to a pressure that end early, and made-up ones beyond."""

    def compute(requests: Sequence[Request]) -> list[Answer]:
        configs = [each.config for each in requests]
        return [
            ended(each, "contact") if each.experiment.max_pressure_kPa <= beyond_kPa
            else grasp(each) for each in configs
        ]  # fmt: skip

    return compute


def test_no_result_follows_from_grasps_that_ended_early() -> None:
    """Neither where all of them did, nor below the least pressure that is known to lift."""
    none = pickup.pickup_pressure(GraspTrials(Config(), some_end(300.0)), 25.0, 100.0)
    assert none.least_kPa is None
    assert none.undecided is not None
    assert none.undecided.picked_up is None
    lifts_kPa = 25.0 * np.ceil(least_kPa(0.38) / 25.0)
    above = pickup.pickup_pressure(GraspTrials(Config(), some_end(lifts_kPa)), 25.0, 100.0)
    assert above.least_kPa == lifts_kPa + 25.0
    assert above.undecided is not None
    assert above.undecided.pressure_kPa == lifts_kPa
    well_below = GraspTrials(Config(), some_end(lifts_kPa - 50.0))
    assert pickup.pickup_pressure(well_below, 25.0, 200.0).undecided is None
    for beyond_kPa in (300.0, 150.0):  # at both pressures, at the lower one
        with pytest.raises(Unfinished, match=r"μ is not known: .* ended before that was decided"):
            pickup.friction(GraspTrials(Config(), some_end(beyond_kPa)), 155.0, 5.0, 0.05)


def test_a_fault_of_the_program_ends_a_search() -> None:
    """The first grasp tells it; others would meet it, too."""
    made: list[Request] = []

    def compute(requests: Sequence[Request]) -> list[Answer]:
        made.extend(requests)
        return [ended(each.config, "error") for each in requests]

    with pytest.raises(Unfinished, match=r"^invented at 100; this is a fault of dolfingrip$"):
        pickup.pickup_pressure(GraspTrials(Config(), compute), 5.0, 100.0)
    assert len(made) == 1
