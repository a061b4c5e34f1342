"""Noise: estimates from repeats, checks of what is left, verdicts under other noise."""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd
import pytest
from diagnosis.inference import synthetic
from scipy.stats import chi2, multivariate_normal

from dolfingrip.diagnosis import cautions
from dolfingrip.diagnosis.inference.alternatives import (
    BELIEVED,
    PRIOR,
    PRIOR_IN_PART,
    alternatives,
    in_part,
)
from dolfingrip.diagnosis.inference.analysis import Analysis
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import ChannelNoise, noise_matrix
from dolfingrip.diagnosis.inference.noise_estimate import from_repeats
from dolfingrip.diagnosis.inference.repeats import places
from dolfingrip.diagnosis.inference.whiteness import check_noise

DRIFTING = {name: each.with_correlated_part(0.9, 60.0) for name, each in synthetic.NOISE.items()}


def angles(specimens: int) -> pd.DataFrame:
    table = synthetic.index(specimens)
    return table[table["channel"] == "angle_deg"].reset_index(drop=True)


def measured(
    table: pd.DataFrame, noise: dict[str, ChannelNoise], rng: np.random.Generator
) -> np.ndarray:
    """Readings of specimens whose stiffness scatters by 5 %."""
    names = table["specimen"]
    scale = dict(zip(names.unique(), 1 + 0.05 * rng.normal(size=names.nunique()), strict=True))
    true = synthetic.base(table) * names.map(scale).to_numpy()
    return true + Covariance.of(noise_matrix(table, noise)).sample(rng, 1)[:, 0]


def test_places_are_shared_by_specimens_or_by_cycles() -> None:
    table = synthetic.index(specimens=2, cycles=2, points=3)
    by_specimen = places(table)
    assert np.bincount(by_specimen).tolist() == [2] * 24
    assert np.bincount(places(table, ("specimen", "cycle"))).tolist() == [4] * 12
    other = table.copy()
    other.loc[other["specimen"] == "finger 1", "pressure_kPa"] += 20
    assert np.bincount(places(other)).max() == 1
    drawn = table.assign(design=table["specimen"])
    assert np.bincount(places(drawn)).max() == 1, "specimens that are drawn in different ways"
    with pytest.raises(ValueError, match="repeats across rate"):
        places(table, ("rate",))


def test_independent_noise_is_found_without_bias() -> None:
    seed = 30
    print("seed", seed)
    rng, table = np.random.default_rng(seed), angles(3)
    found = [
        from_repeats(table, measured(table, synthetic.NOISE, rng), places(table)) for _ in range(25)
    ]
    std = [each.noise.total_std() for each in found if each is not None]
    correlated = np.mean([each.correlation_p < 0.05 for each in found if each is not None])
    print(f"{np.mean(std):.3f} ± {np.std(std):.3f}, called correlated {correlated}")
    assert len(std) == 25
    assert np.mean(std) == pytest.approx(0.3, rel=0.05)
    assert correlated <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 25)


def test_correlated_noise_is_found() -> None:
    seed = 31
    print("seed", seed)
    rng, table = np.random.default_rng(seed), angles(4)
    found = [from_repeats(table, measured(table, DRIFTING, rng), places(table)) for _ in range(8)]
    noises = [each.noise for each in found if each is not None and each.correlation_p < 0.05]
    lengths = [noise.length for noise in noises]
    print(f"{len(noises)} of 8, length {np.median(lengths):.0f} s")
    assert len(noises) >= 7
    assert np.median([noise.correlated_std for noise in noises]) == pytest.approx(0.285, rel=0.3)
    assert 25 < np.median(lengths) < 150


def test_the_restricted_likelihood_is_that_of_the_contrasts() -> None:
    # reference: normal density of contrasts that are free of the fixed effects; it differs by a
    # constant, so differences between hyperparameters are compared
    from scipy.linalg import null_space

    from dolfingrip.diagnosis.inference import noise_estimate as module
    from dolfingrip.diagnosis.inference.readings import tracks

    table = angles(2)
    y = measured(table, DRIFTING, np.random.default_rng(32))
    fixed = module.fixed_effects(table, y, places(table))
    runs = tracks(table)
    times = [table["time_s"].to_numpy()[rows] for rows in runs]
    problem = module.Reml(y, fixed, runs, times)
    contrasts = null_space(fixed.T)

    def direct(std: float, correlated: float, length: float) -> float:
        noise = {"angle_deg": ChannelNoise(std, correlated, length)}
        matrix = contrasts.T @ noise_matrix(table, noise) @ contrasts
        return float(multivariate_normal(np.zeros(len(matrix)), matrix).logpdf(contrasts.T @ y))

    one, other = (0.3, 0.1, 20.0), (0.2, 0.4, 70.0)
    difference = problem.log_likelihood(*one) - problem.log_likelihood(*other)
    assert difference == pytest.approx(direct(*one) - direct(*other), abs=1e-8)


def test_the_check_is_chi_squared() -> None:
    # reference: the sum of squares of readings with independent noise, no nuisances
    table = synthetic.index()
    noise = noise_matrix(table, synthetic.NOISE)
    r = np.sqrt(np.diag(noise)) * np.random.default_rng(34).normal(size=44)
    found = check_noise(table, r, Covariance.of(noise)).tests[0]
    total = float((r**2 / np.diag(noise)).sum())
    assert found.value == pytest.approx(np.sqrt(total / 44))
    assert found.p == pytest.approx(2 * min(chi2.sf(total, 44), chi2.cdf(total, 44)))


@pytest.mark.parametrize("believed_right", [True, False])
def test_noise_of_the_wrong_size_is_noticed(believed_right: bool) -> None:
    seed, draws = 35, 150
    print("seed", seed)
    table, rng = synthetic.index(), np.random.default_rng(seed)
    believed = synthetic.covariance(table)
    factor = 1.0 if believed_right else 1.5
    true = {name: each.scaled(factor) for name, each in synthetic.NOISE.items()}
    residuals = synthetic.covariance(table, true).sample(rng, draws)
    checks = [check_noise(table, r, believed) for r in residuals.T]
    share = np.mean([check.too_small for check in checks])
    failed = np.mean([bool(check.failed) for check in checks])
    print(f"too small {share}, any {failed}")
    if believed_right:
        assert failed <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / draws)
    else:
        assert share > 0.8
        worst = max(checks, key=lambda check: check.tests[0].value)
        assert "times the noise that was assumed" in worst.notes()[0]


def test_correlated_noise_believed_independent_is_noticed() -> None:
    seed, draws = 36, 150
    print("seed", seed)
    table, rng = synthetic.index(), np.random.default_rng(seed)
    residuals = synthetic.covariance(table, DRIFTING).sample(rng, draws)
    checks = [check_noise(table, r, synthetic.covariance(table)) for r in residuals.T]
    share = np.mean([check.correlated for check in checks])
    print(f"noticed {share}")
    assert share > 0.8
    assert any("neighbouring readings" in note for check in checks for note in check.notes())


@pytest.mark.parametrize(("length_s", "share"), [(40.0, 0.25), (1000.0, 0.25), (40.0, 0.0)])
def test_a_quarter_that_drifts_is_noticed(length_s: float, share: float) -> None:
    """By noise of which a quarter drifts, over a run or less; noise that is mostly drift is less
    probable than independent noise there. Independent noise is hardly ever doubted."""
    seed, draws = 40, 100
    print("seed", seed)
    table, rng = synthetic.index(specimens=4, cycles=2), np.random.default_rng(seed)
    true = {k: each.with_correlated_part(share, length_s) for k, each in synthetic.NOISE.items()}
    few = alternatives(synthetic.NOISE, 60.0)
    more = few | in_part(synthetic.NOISE, 60.0)
    prior = PRIOR | PRIOR_IN_PART
    density = {name: synthetic.covariance(table, noise) for name, noise in more.items()}
    doubted = {"few": 0, "more": 0}
    for residual in synthetic.covariance(table, true).sample(rng, draws).T:
        logs = {name: each.log_density(residual) for name, each in density.items()}
        for label, names in (("few", few), ("more", more)):
            odds = [prior[name] / prior[BELIEVED] * np.exp(logs[name] - logs[BELIEVED])
                    for name in names]  # fmt: skip
            doubted[label] += 1 / sum(odds) < 0.1
    print(doubted)
    if share:
        assert 2 * doubted["few"] < doubted["more"]
        assert doubted["more"] >= 80
    else:
        assert doubted["more"] <= 5


@cache
def analyses() -> dict[str, Analysis]:
    table = synthetic.index()
    return {
        name: Analysis(table, synthetic.screen(table, noise), synthetic.noise_std(table, noise))
        for name, noise in alternatives(synthetic.NOISE, 60.0).items()
    }


@pytest.mark.parametrize("trap", ["correlated", "larger"])
def test_doubtful_noise_makes_no_false_alarms(trap: str) -> None:
    seed, draws = 37, 30
    print("seed", seed)
    table, rng = synthetic.index(), np.random.default_rng(seed)
    larger = {name: each.scaled(1.5) for name, each in synthetic.NOISE.items()}
    true = DRIFTING if trap == "correlated" else larger
    naive, careful, noticed = [], [], []
    for residual in synthetic.covariance(table, true).sample(rng, draws).T:
        verdict, _, probability = synthetic.judged(analyses(), residual, PRIOR)
        believed = analyses()[BELIEVED]
        naive.append(synthetic.verdict(believed, residual).answer != "none")
        careful.append(verdict.answer != "none")
        check = believed.check(residual, believed.findings(residual))
        noticed.append(probability[BELIEVED] < 0.5 or bool(check.failed))
    print(f"false alarms: as believed {np.mean(naive)}, over models {np.mean(careful)}; "
          f"noticed {np.mean(noticed)}")  # fmt: skip
    assert np.mean(careful) < np.mean(naive)
    assert np.mean(careful) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / draws)
    assert np.mean(noticed) > 0.8


def test_a_strong_effect_is_named_under_all_models() -> None:
    table = synthetic.index()
    rng = np.random.default_rng(38)
    r = (
        synthetic.columns(table)["hardening"] * 1.2
        + synthetic.covariance(table).sample(rng, 1)[:, 0]
    )
    verdict, under, probability = synthetic.judged(analyses(), r, PRIOR)
    assert verdict.names == ("hardening",)
    assert {each.names for each in under.values()} == {("hardening",)}
    assert sum(probability.values()) == pytest.approx(1.0)
    assert probability[BELIEVED] > 0.3


def test_how_a_verdict_depends_on_the_noise_is_said() -> None:
    table, rng = synthetic.index(), np.random.default_rng(39)
    r = 1.5 * synthetic.covariance(table, DRIFTING).sample(rng, 1)[:, 0]
    verdict, under, probability = synthetic.judged(analyses(), r, PRIOR)
    assert probability[BELIEVED] < 0.5
    others = {name for name, each in under.items() if each.answer != verdict.answer}
    notes = cautions.of_noise(verdict, under, probability)
    assert BELIEVED in others
    assert any(note.startswith(f"with noise {BELIEVED} (probability 0.") for note in notes)
