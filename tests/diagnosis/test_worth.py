"""What an addition is worth between fits, by closed forms; no simulation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from dolfingrip.diagnosis.additions import memory
from dolfingrip.diagnosis.additions.covariance import Covariance
from dolfingrip.diagnosis.additions.worth import Expected, Fitted, chance_alone
from dolfingrip.diagnosis.data import planned
from dolfingrip.diagnosis.data.lab_setup import LabSetup
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.outcome import NextExperiment

SEED = 4
STD = 0.02
LAWS = {1: 1.0, 4: 0.2}
"""Numbers of terms, and the standard deviations of their sizes by their priors."""


def fits(reach: float, count: int = 20) -> tuple[Covariance, list[Fitted], list]:
    """Force by travel of laws of one power and of four, both fitted to 0.6 x².

    What the larger law has more is not needed, so that both follow the readings alike.
    """
    x = np.linspace(0, reach, count)
    covariance = Covariance.of(STD**2 * np.eye(count) + 0.05**2 * np.outer(x, x))
    found, readings = [], []
    for terms, spread in LAWS.items():
        slopes = np.column_stack([spread * x ** (2 + k) for k in range(terms)])
        zeta = np.array([0.6 / spread, *np.zeros(terms - 1)])
        found.append(cast(Fitted, SimpleNamespace(zeta=zeta)))
        readings.append((slopes @ zeta, slopes))
    return covariance, found, readings


def test_expected_odds_are_those_of_drawn_readings() -> None:
    """Against the mean of ln N(y; 0, C + J Jᵀ) over drawn readings."""
    print("seed", SEED)
    covariance, laws, readings = fits(1.0)
    expected = Expected.of(laws, covariance, readings)
    normal = np.random.default_rng(SEED).standard_normal((len(covariance), 4000))
    drawn = covariance.factor @ normal
    own = [covariance.widened(slopes) for _, slopes in readings]
    for i, (true, _) in enumerate(readings):
        logs = np.array([
            [each.log_density(y) for each in own] for y in (true[:, None] + drawn).T
        ])  # fmt: skip
        odds = logs[:, [i]] - logs
        error = odds.std(axis=0) / np.sqrt(len(odds))
        assert (np.abs(odds.mean(axis=0) - expected.log_odds[i]) <= 4 * error + 1e-9).all()
    np.testing.assert_allclose(expected.misfit, 0.0, atol=1e-9)


NO_PAIR = np.zeros((2, 2), dtype=bool)


@pytest.mark.parametrize(("reach", "chance"), [(1.0, 0.0), (3.0, 0.5)])
def test_a_law_of_many_terms_is_refuted_by_more_travel(reach: float, chance: float) -> None:
    """Its misfit stays 0. What it has more of cannot be refuted if it is there, so that only the
    law of one term, of probability 0.5, is left alone."""
    covariance, laws, readings = fits(1.0)
    now = Expected.of(laws, covariance, readings)
    then = Expected.of(laws, *fits(reach)[::2])
    before = np.array([0.5, 0.5])
    print(now.log_odds, then.log_odds)
    assert chance_alone(before, now, then, NO_PAIR) == pytest.approx(chance)


def test_pairs_that_differ_are_told_apart() -> None:
    covariance = Covariance.of(STD**2 * np.eye(2))
    laws = [cast(Fitted, SimpleNamespace(zeta=np.ones(1)))] * 2
    alike = [(np.array([1.0, 0.0]), np.array([[1.0], [0.0]])),
             (np.array([1.0, 0.001]), np.array([[1.0], [0.001]]))]  # fmt: skip
    other = [alike[0], (np.array([1.0, 0.2]), np.array([[1.0], [0.2]]))]
    equal = np.array([0.5, 0.5])
    now = Expected.of(laws, covariance, alike)
    assert chance_alone(equal, now, now, NO_PAIR) == 0.0
    then = Expected.of(laws, covariance, other)
    assert chance_alone(equal, now, then, NO_PAIR) == 1.0
    assert chance_alone(equal, now, then, ~np.eye(2, dtype=bool)) == 0.0
    assert _worth("a hold", 2.0, 1.0, 0.5, 0.8).splits


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


def pulled(way: Sequence[tuple[str, int]], rate_mm_per_s: float) -> Measurement:
    """A coupon's readings to be."""
    test = SpecimenTest(0, Path("coupon.csv"), "coupon", "A", LabSetup())
    return Measurement(planned.rows(test, way, [4.0, 8.0], rate_mm_per_s, ("force_N",)), [test])


def test_memory_shows_where_a_loading_at_one_rate_is_not_all() -> None:
    """A Prony series, fitted anew, follows an elastic law's loading."""
    once = [("loading", 1)]
    known = pulled(once, 0.5)
    assert not memory.shows(known, pulled(once, 0.5))
    assert memory.shows(known, pulled(once, 0.05))
    assert memory.shows(known, pulled([*once, ("unloading", 1)], 0.5))
    assert memory.shows(known, pulled([*once, ("hold", 1)], 0.5))
    assert memory.shows(pulled(planned.cycles(2), 0.5), known)


def test_density_and_whitening_are_those_of_the_normal_law() -> None:
    # reference: scipy's multivariate normal density
    rng = np.random.default_rng(8)
    root = rng.normal(size=(6, 6))
    matrix = root @ root.T + np.eye(6)
    covariance, r = Covariance.of(matrix), rng.normal(size=6)
    assert covariance.log_density(r) == pytest.approx(
        multivariate_normal(np.zeros(6), matrix).logpdf(r)
    )
    column = rng.normal(size=6)
    assert covariance.widened(column).matrix == pytest.approx(matrix + np.outer(column, column))
    with pytest.raises(ValueError, match="not positive definite"):
        Covariance.of(np.zeros((3, 3)))
