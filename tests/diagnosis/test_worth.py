"""What an addition is worth between fits, by closed forms; no simulation."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import multivariate_normal

from dolfingrip.diagnosis.additions.worth import (
    Comparison,
    Expected,
    Rival,
    chance_alone,
    told_apart,
)
from dolfingrip.diagnosis.answer.analysis import told_by_shape
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.lab_setup import LabSetup
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest, shows_memory
from dolfingrip.files.diagnosis import NextExperiment, PlannedTest
from dolfingrip.sections.procedure import ExperimentSettings

SEED = 4
ONCE, TWICE = ExperimentSettings(), ExperimentSettings(cycles=2)
STD = 0.02
LAWS = {1: 1.0, 4: 0.2}
"""Numbers of terms, and the standard deviations of their sizes by their priors."""


def fits(reach: float, count: int = 20) -> tuple[list[Rival], np.ndarray]:
    """Force by travel of laws of one power and of four, both fitted to 0.6 x², and its covariance.

    What the larger law has more is not needed, so that both follow the readings alike.
    """
    x = np.linspace(0, reach, count)
    found = []
    for terms, spread in LAWS.items():
        slopes = np.column_stack([spread * x ** (2 + k) for k in range(terms)])
        zeta = np.array([0.6 / spread, *np.zeros(terms - 1)])
        found.append(Rival(zeta, slopes @ zeta, slopes))
    return found, STD**2 * np.eye(count) + 0.05**2 * np.outer(x, x)


def test_expected_odds_are_those_of_drawn_readings() -> None:
    """Against the mean of ln N(y; 0, C + J Jᵀ) over drawn readings."""
    # reference: scipy's multivariate normal density
    print("seed", SEED)
    laws, covariance = fits(1.0)
    expected = Expected.of(laws, covariance)
    rng = np.random.default_rng(SEED)
    drawn = rng.multivariate_normal(np.zeros(len(covariance)), covariance, 4000)
    own = [multivariate_normal(cov=covariance + law.slopes @ law.slopes.T) for law in laws]
    for i, law in enumerate(laws):
        logs = np.column_stack([each.logpdf(law.readings + drawn) for each in own])
        odds = logs[:, [i]] - logs
        error = odds.std(axis=0) / np.sqrt(len(odds))
        assert (np.abs(odds.mean(axis=0) - expected.log_odds[i]) <= 4 * error + 1e-9).all()
    np.testing.assert_allclose(expected.misfit, 0.0, atol=1e-9)


NO_PAIR = np.zeros((2, 2), dtype=bool)


@pytest.mark.parametrize(("reach", "chance"), [(1.0, 0.0), (3.0, 0.5)])
def test_a_law_of_many_terms_is_refuted_by_more_travel(reach: float, chance: float) -> None:
    """Its misfit stays 0. What it has more of cannot be refuted if it is there, so that only the
    law of one term, of probability 0.5, is left alone."""
    now, then = Expected.of(*fits(1.0)), Expected.of(*fits(reach))
    before = np.array([0.5, 0.5])
    print(now.log_odds, then.log_odds)
    apart = told_apart(before, now, then, NO_PAIR)
    assert chance_alone(before, apart) == pytest.approx(chance)


def test_pairs_that_differ_are_told_apart() -> None:
    covariance = STD**2 * np.eye(2)

    def laws(second: float) -> list[Rival]:
        found = [np.array([1.0, each]) for each in (0.0, second)]
        return [Rival(np.ones(1), each, each[:, None]) for each in found]

    equal = np.array([0.5, 0.5])
    now = Expected.of(laws(0.001), covariance)
    assert chance_alone(equal, told_apart(equal, now, now, NO_PAIR)) == 0.0
    then = Expected.of(laws(0.2), covariance)
    assert chance_alone(equal, told_apart(equal, now, then, NO_PAIR)) == 1.0
    assert chance_alone(equal, told_apart(equal, now, then, ~np.eye(2, dtype=bool))) == 0.0
    assert _worth("a hold", 2.0, 1.0, 0.5, 0.8).splits


@pytest.mark.parametrize(("reach", "elastic", "chance"), [(1.0, False, 1.0), (1.0, True, 0.0),
                                                          (4.0, True, 1.0)])  # fmt: skip
def test_laws_are_told_apart_by_a_hundredth(reach: float, elastic: bool, chance: float) -> None:
    """However fine the noise, a curve that is 0.15 % off tells no law; one 2 % off does.

    Reference: of x³ beside a multiple of x stays (1/7 − 9/75)^½ = 0.15 of the largest, by hand.
    """
    x, more = np.linspace(0, 1.0, 15), np.linspace(0, reach, 15)

    def laws(at: np.ndarray) -> list[Rival]:
        curves = [at, at + 0.01 * at**3]
        return [Rival(np.ones(1), curve, at[:, None], frozenset({name}), own=1)
                for curve, name in zip(curves, ("yeoh", "ogden"), strict=True)]  # fmt: skip

    test = PlannedTest(experiment="coupon", specimen="A", control="displacement_mm", read=(),
                       branch=(), cycle=(), time_s=(), value=())  # fmt: skip
    measurement = pulled(ONCE, 0.5, x[1:])
    addition: Any = SimpleNamespace(
        name="more", minutes=15.0, tests=(test,), quantities=(), columns=["force_N"] * 15
    )
    noise = 1e-5 * np.ones(15)
    comparison = Comparison(
        measurement, noise, np.diag(noise**2), np.array([0.6, 0.4]), laws(x),
        elastic=frozenset({"yeoh", "ogden"} if elastic else ()),
    )  # fmt: skip
    weighed = comparison.worth(addition, laws(more), np.diag(noise**2))
    assert weighed.chance == pytest.approx(chance)


@pytest.mark.parametrize(("shared", "chance"), [(0.0, 1.0), (0.2, 0.0)])
def test_what_another_specimen_may_do_tells_no_law(shared: float, chance: float) -> None:
    """A tenth of x² beside a law misses a hundredth, unless a specimen's own fifth takes it up."""
    x = np.linspace(0, 1.0, 15)

    def laws(more: float) -> list[Rival]:
        curves = [x, x + 0.01 * x**3 + more * x**2]
        return [Rival(np.ones(1), curve, x[:, None], frozenset({name}), own=1)
                for curve, name in zip(curves, ("yeoh", "ogden"), strict=True)]  # fmt: skip

    addition: Any = SimpleNamespace(
        name="another", minutes=15.0, tests=(), quantities=(), columns=["force_N"] * 15
    )
    noise = 1e-5 * np.ones(15)
    comparison = Comparison(
        pulled(ONCE, 0.5, x[1:]), noise, np.diag(noise**2), np.array([0.6, 0.4]),
        laws(0.0), elastic=frozenset({"yeoh", "ogden"}),
    )  # fmt: skip
    between = shared**2 * np.outer(x**2, x**2)
    weighed = comparison.worth(addition, laws(0.1), np.diag(noise**2), between)
    assert weighed.chance == pytest.approx(chance)


def _worth(
    name: str, minutes: float, gain: float, by_minute: float, chance: float
) -> NextExperiment:
    return NextExperiment(
        name=name, minutes=minutes, gain=gain, gain_per_minute=by_minute, chance=chance
    )


def test_the_quickest_way_to_a_split_comes_first() -> None:
    """26 certain minutes before 25 that may not do; then by what is told a minute."""
    sure = _worth("sure", 26.0, 30.0, 0.7, 1.0)
    likely = _worth("likely", 25.0, 40.0, 0.75, 0.85)
    dear = _worth("dear", 60.0, 900.0, 0.3, 1.0)
    little, less = (_worth(f"{gain}", 5.0, gain, gain / 5, 0.7) for gain in (9.0, 2.0))
    ranked = sorted([less, dear, little, likely, sure], key=lambda each: each.rank)
    assert [each.name for each in ranked] == ["sure", "likely", "dear", "9.0", "2.0"]


def pulled(
    way: ExperimentSettings, rate_mm_per_s: float, travel_mm: Any = (4.0, 8.0)
) -> Measurement:
    """A coupon's readings to be."""
    test = SpecimenTest(0, Path("coupon.csv"), "coupon", "A", LabSetup())
    rows = rig.planned_rows(test, way, travel_mm, rate_mm_per_s, ("force_N",))
    return Measurement(rows, [test])


def test_memory_shows_where_a_loading_at_one_rate_is_not_all() -> None:
    """A Prony series, fitted anew, follows an elastic law's loading."""
    known = pulled(ONCE, 0.5)
    assert not shows_memory(known, pulled(ONCE, 0.5))
    assert shows_memory(known, pulled(ONCE, 0.05))
    assert shows_memory(known, pulled(ExperimentSettings(unload=True), 0.5))
    assert shows_memory(known, pulled(ExperimentSettings(hold_s=60.0), 0.5))
    assert shows_memory(pulled(TWICE, 0.5), known)


def test_no_elastic_law_rivals_what_free_bending_does_not_feel() -> None:
    """A law changes free bending and the blocked force, a plate's friction the force alone."""
    names = ("prony", "plate_friction", "mooney_rivlin")
    blocked = loaded("blocked_force")
    assert told_by_shape(names, blocked) == {"prony", "plate_friction"}
    assert told_by_shape(names, loaded("bending", "blocked_force")) == {"prony"}
    assert not told_by_shape(names, loaded("bending", way=TWICE))


def loaded(*experiments: str, way: ExperimentSettings = ONCE) -> Measurement:
    """A finger's readings to be."""
    tests = [
        SpecimenTest(i, Path("lab.csv"), name, "A", LabSetup())
        for i, name in enumerate(experiments)
    ]
    rows = [rig.planned_rows(test, way, [50.0, 100.0], 25.0, ("angle_deg",)) for test in tests]
    return Measurement(pd.concat(rows, ignore_index=True), tests)
