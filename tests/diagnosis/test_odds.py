"""Whether a cause beats its rivals, on drawn readings of a finger that is linear in everything."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, cast

import numpy as np
import pandas as pd
import pytest
from diagnosis.inference import synthetic

from dolfingrip.diagnosis.gain.folds import folds
from dolfingrip.diagnosis.gain.gain import gains
from dolfingrip.diagnosis.gain.odds import CLEAR, Odds, claimed, least_log_odds, mean_log_odds
from dolfingrip.diagnosis.gain.rivals import NuisanceFit
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import ChannelNoise, noise_matrix
from dolfingrip.diagnosis.inference.unknown import smooth_changes
from dolfingrip.diagnosis.model import FreeParameter
from dolfingrip.extensions.effect import Prior

TABLE = synthetic.index().assign(rate_kPa_per_s=2.5, displacement_mm=np.nan)
BASE = synthetic.base(TABLE)
STD = synthetic.noise_std(TABLE)
NUISANCES = synthetic.nuisances(TABLE)
ANGLE = synthetic.is_angle(TABLE)
DRAWS = 30


@dataclass(frozen=True)
class Drawn:
    """As much of a problem as folds need."""

    value: np.ndarray
    noise: dict[str, ChannelNoise]
    index: ClassVar[pd.DataFrame] = TABLE
    nuisances: ClassVar[np.ndarray] = NUISANCES
    simulated: ClassVar[np.ndarray] = BASE
    noise_std: ClassVar[np.ndarray] = STD

    def with_noise(self, noise: dict[str, ChannelNoise]) -> Drawn:
        return replace(self, noise=noise)

    @cached_property
    def error_covariance(self) -> Covariance:
        return Covariance.of(noise_matrix(self.index, self.noise))

    @cached_property
    def covariance(self) -> Covariance:
        return self.error_covariance.widened(self.nuisances)


def hypothesis(effect: str, *columns: np.ndarray) -> Hypothesis:
    jacobian = np.column_stack([np.zeros((len(BASE), 0)), *columns])
    free = [FreeParameter(effect, Prior(0.0, 1.0, "drawn"), -10.0, 10.0)] * len(columns)
    return Hypothesis(
        (effect,) if effect else (), tuple(free), np.zeros(len(columns)), BASE, jacobian
    )


def drawn(change: np.ndarray, rng: np.random.Generator) -> Any:
    noise = STD * rng.standard_normal(len(BASE))
    moved = NUISANCES @ rng.standard_normal(2)
    return cast(Any, Drawn(BASE + change + moved + noise, dict(synthetic.NOISE)))


def softer_loop() -> np.ndarray:
    """Angles that are larger on unloading, by up to 5 standard deviations."""
    x = synthetic.load(TABLE)
    unloading = (TABLE["branch"] == "unloading").to_numpy()
    return np.where(ANGLE & unloading, 5 * 0.3 * 4 * x * (1 - x), 0.0)


def share(change: np.ndarray, cause: np.ndarray, seed: int, draws: int = DRAWS) -> float:
    """Of draws in which ``cause`` is claimed where ``change`` is there."""
    rng = np.random.default_rng(seed)
    print(f"seed {seed}")
    told = hypothesis("told", cause)
    return float(
        np.mean([claimed(gains(drawn(change, rng), hypothesis(""), told)[1]) for _ in range(draws)])
    )


def test_a_cause_that_is_there_beats_both_rivals() -> None:
    """Though it changes one channel of two, and others' errors differ by chance."""
    assert share(softer_loop(), softer_loop(), 1) >= 0.9


def test_a_cause_that_is_not_there_beats_neither() -> None:
    """At most 5 % by Markov's inequality; in all seven effects and draws, none is expected."""
    nothing = np.zeros(len(BASE))
    every = [softer_loop(), *list(synthetic.columns(TABLE).values())[:4]]
    assert np.mean([share(nothing, cause, 2 + n, 12) for n, cause in enumerate(every)]) <= 0.05


def test_a_cause_that_spoils_one_channel_is_refused() -> None:
    """It has the angle right and changes the force by 3 standard deviations, which is not there."""
    x = synthetic.load(TABLE)
    spoilt = softer_loop() + np.where(ANGLE, 0.0, 3 * 0.02 * np.sin(9 * x))
    rng = np.random.default_rng(3)
    odds = gains(drawn(3 * softer_loop(), rng), hypothesis(""), hypothesis("told", spoilt))[1]
    assert mean_log_odds(odds, "nuisances") > 100
    assert least_log_odds(odds, "nuisances") < -20
    assert not claimed(odds)


def test_a_process_that_explains_it_refuses_a_cause() -> None:
    """A smooth change of any shape; the cause has much of it, so that it beats nuisances."""
    rng = np.random.default_rng(4)
    features = smooth_changes(TABLE) * STD[:, None]
    change = 6 * features @ rng.standard_normal(features.shape[1])
    cause = change * (1 + 0.4 * np.sin(12 * synthetic.load(TABLE)))
    odds = gains(drawn(change, rng), hypothesis(""), hypothesis("told", cause))[1]
    assert mean_log_odds(odds, "nuisances") > np.log(CLEAR)
    assert least_log_odds(odds, "process") < -20
    assert not claimed(odds)


def test_nuisances_do_not_chase_a_strong_effect_on_one_channel() -> None:
    """A force that is off by 100 standard deviations: with the noise as told, stiffness and
    pressure follow its loading at the cost of the angle."""
    problem = drawn(np.where(ANGLE, 0.0, 100 * 0.02 * np.sin(3 * synthetic.load(TABLE))),
                    np.random.default_rng(6))  # fmt: skip
    loading = (TABLE["branch"] == "loading").to_numpy()
    fair = NuisanceFit(problem, hypothesis("")).refitted(loading).predicted
    chasing = hypothesis("").predicted(problem, loading)
    errors = [
        float(np.sqrt(np.mean((problem.value - each)[ANGLE] ** 2))) for each in (fair, chasing)
    ]
    print(errors)
    assert errors[0] < 0.5 * errors[1]


def row(channel: str | None, *logs: float) -> Odds:
    return Odds("load bands", channel, logs, logs)


@pytest.mark.parametrize(
    ("force", "told"), [((-0.1, -0.2), True), ((-2.0, -1.5), True), ((-3.0, -2.0), False)]
)
def test_a_channel_is_lost_where_its_odds_are_clear(force: tuple[float, ...], told: bool) -> None:
    """20 to 1, times the number of looks: e^3.7 with two of them."""
    assert (
        claimed([row(None, 0.1, 9.0), row("angle_deg", 5.0, 4.0), row("force_N", *force)]) is told
    )


def test_looks_are_counted() -> None:
    """One part of two with 30 to 1 is 15 to 1; with 50 to 1 it is enough."""
    assert not claimed([row(None, np.log(30), 0.0), row("angle_deg", 1.0)])
    assert claimed([row(None, np.log(50), 0.0), row("angle_deg", 1.0)])
    assert not claimed([])


def test_one_part_alone_does_not_decide() -> None:
    """Nuisances that foretell one experiment from another with false certainty."""
    one = Odds("experiments", "force_N", (7.0, 0.1), (7.0, 0.1))
    wrong = Odds("experiments", None, (7.0, 0.1), (7.0, 0.1))
    others = [Odds(kind, None, (0.4, 0.1), (0.4, 0.1)) for kind in ("load bands", "branches")]
    assert mean_log_odds([wrong, *others], "nuisances") > np.log(CLEAR)
    assert not claimed([wrong, *others, one])
    assert claimed([wrong, one])


def test_a_process_has_to_be_worse_in_sum() -> None:
    """However clear it is that the nuisances are."""
    clear = (9.0, 8.0)
    one = Odds("load bands", "force_N", (9.0, 8.0), (0.5, -0.9))
    assert not claimed([Odds("load bands", None, clear, (0.5, -0.9)), one])
    assert claimed([Odds("load bands", None, clear, (0.9, -0.5)), one])


def test_a_coupon_has_no_rate_of_the_pressure() -> None:
    rates = np.where(ANGLE, 2.5, np.nan)
    assert "rates" not in folds(TABLE.assign(rate_kPa_per_s=rates))
    assert "rates" in folds(TABLE.assign(rate_kPa_per_s=np.where(ANGLE, 2.5, 25.0)))
