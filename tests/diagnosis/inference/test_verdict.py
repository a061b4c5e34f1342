"""Verdicts are calibrated: Monte Carlo on synthetic columns, and the traps."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from diagnosis.inference import synthetic

from dolfingrip.diagnosis.inference.analysis import Analysis
from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import noise_matrix
from dolfingrip.diagnosis.inference.posterior import HypothesisWeights
from dolfingrip.diagnosis.inference.screen import Screen
from dolfingrip.diagnosis.inference.thresholds import (
    DRAWS,
    FALSE_ALARMS,
    draw_without_visible,
)
from dolfingrip.diagnosis.inference.verdict import LIKELY, Verdict
from dolfingrip.diagnosis.simulation.meshes import SHARE

TIED = {"plate_friction", "no_self_contact"}


def hidden(
    analysis: Analysis, rng: np.random.Generator, strength_sigma: float | None = None
) -> tuple[str, np.ndarray]:
    """A residual with one effect, and its name."""
    number = int(rng.integers(len(analysis.screen.candidates)))
    change = analysis.screen.draw_change(number, rng)
    if strength_sigma is not None:
        change = change * strength_sigma / np.linalg.norm(change)
    residual = analysis.covariance.factor @ (change + rng.standard_normal(len(change)))
    return analysis.screen.candidates[number].name, residual


def test_false_alarms_are_rare() -> None:
    seed, draws = 20, 150
    print("seed", seed)
    analysis, rng = synthetic.analysis(), np.random.default_rng(seed)
    answers = Counter(
        synthetic.verdict(analysis, r).answer for r in analysis.covariance.sample(rng, draws).T
    )
    print(answers)
    # at most 5 %, and two standard errors of that many draws
    assert 1 - answers["none"] / draws <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / draws)


def test_claims_are_right_and_ties_are_not_resolved() -> None:
    seed, draws = 21, 150
    print("seed", seed)
    analysis, rng = synthetic.analysis(), np.random.default_rng(seed)
    outcomes, called_unknown = [], 0
    for _ in range(draws):
        true, residual = hidden(analysis, rng)
        verdict = synthetic.verdict(analysis, residual)
        called_unknown += verdict.answer == "unknown"
        for found in verdict.named:
            assert not TIED & set(found.names) or set(found.names) >= TIED
        if verdict.answer == "cause" and verdict.probability >= 0.9:
            outcomes.append(true in verdict.names)
    print(f"{len(outcomes)} claims of {draws}, right {np.mean(outcomes)}, unknown {called_unknown}")
    assert len(outcomes) > 0.6 * draws
    assert np.mean(outcomes) >= 0.97 - 2 * np.sqrt(0.03 * 0.97 / len(outcomes))
    assert called_unknown <= (0.05 + 2 * np.sqrt(0.05 * 0.95 / draws)) * draws


def test_what_is_less_likely_than_not_is_not_named_alone() -> None:
    seed, draws = 31, 80
    print("seed", seed)
    analysis, rng = synthetic.analysis(), np.random.default_rng(seed)
    widened = 0
    for _ in range(draws):
        verdict = synthetic.verdict(analysis, hidden(analysis, rng, strength_sigma=3.5)[1])
        if verdict.answer != "cause":
            continue
        every = {name for found in verdict.table for name in found.names}
        assert verdict.probability > LIKELY or set(verdict.names) == every
        if len(verdict.named) == 1 and verdict.table[0].probability <= LIKELY:
            widened += 1
            assert set(verdict.names) > set(verdict.table[0].names)
            assert verdict.probability == pytest.approx(verdict.named[0].probability)
    print(f"{widened} widened")
    assert widened


def test_probabilities_of_weak_effects_are_frequencies() -> None:
    # at strengths where mistakes happen, claims of probability p are right in p of the cases
    seed, draws = 22, 400
    print("seed", seed)
    table, rng = synthetic.index(points=6), np.random.default_rng(seed)
    covariance = synthetic.covariance(table)
    weak = [
        Candidate(name, (Shape(0.12 * v),), 0.0, 1.5)
        for name, v in synthetic.columns(table).items()
        if name != "no_self_contact"
    ]
    p, right = [], []
    for _ in range(draws):
        true = int(rng.integers(len(weak)))
        _, strength = weak[true].draw(rng)
        residual = strength * weak[true].shapes[0].change + covariance.sample(rng, 1)[:, 0]
        found = synthetic.exact_posterior(residual, weak, covariance)[1:]
        p.append(found.max())
        right.append(found.argmax() == true)
    p, right = np.array(p), np.array(right)
    for low, high in ((0.0, 0.4), (0.4, 0.8), (0.8, 1.01)):
        chosen = (p >= low) & (p < high)
        error = np.sqrt((p[chosen] * (1 - p[chosen])).sum()) / chosen.sum()
        print(f"{low}–{high}: said {p[chosen].mean():.3f}, right {right[chosen].mean():.3f}")
        assert chosen.sum() > 20
        assert right[chosen].mean() == pytest.approx(p[chosen].mean(), abs=3 * error)


def test_more_noise_makes_verdicts_more_cautious() -> None:
    table = synthetic.index()
    plain, doubled = synthetic.analysis(), synthetic.analysis(2.0)
    residual = synthetic.columns(table)["softening"]
    one, other = synthetic.verdict(plain, residual), synthetic.verdict(doubled, residual)
    assert other.none > one.none
    index = [score.name for score in one.scores].index("softening")
    assert other.scores[index].amplitude.std > 1.3 * one.scores[index].amplitude.std
    assert other.table[0].probability < one.table[0].probability


def test_shuffled_readings_are_no_cause_of_the_catalogue() -> None:
    # an effect's change in random order and of random signs points nowhere: names are right by
    # chance, and cannot be claimed
    seed, draws = 23, 80
    print("seed", seed)
    analysis, rng = synthetic.analysis(), np.random.default_rng(seed)
    first, claims = 0, 0
    for _ in range(draws):
        true, residual = hidden(analysis, rng, 6.0)
        white = rng.permutation(analysis.covariance.whiten(residual)) * rng.choice([-1, 1], 44)
        verdict = synthetic.verdict(analysis, analysis.covariance.factor @ white)
        best = max(verdict.scores, key=lambda score: score.log_evidence)
        first += best.name == true
        claims += verdict.answer == "cause" and verdict.probability >= 0.9
    chance = 1 / len(analysis.screen.candidates)
    print(f"first {first / draws} (chance {chance}), claims {claims / draws}")
    assert first / draws == pytest.approx(chance, abs=3 * np.sqrt(chance / draws))
    assert claims / draws < 0.15


def outsider(analysis: Analysis, rng: np.random.Generator, unexplained: float) -> np.ndarray:
    """A smooth change by no candidate: what the best of them leaves has this length (σ)."""
    table, screen = analysis.index, analysis.screen
    x, angle = synthetic.load(table), synthetic.is_angle(table)
    unit = np.where(angle, 0.3 * rng.normal(), 0.02 * rng.normal())
    change = unit * np.sin(rng.uniform(2, 6) * x + rng.uniform(0, 6))
    white = analysis.covariance.whiten(change)
    along = np.abs(screen.score_sigma(white[:, None])[:, 0]).max() / np.linalg.norm(white)
    white *= unexplained / (np.linalg.norm(white) * np.sqrt(1 - along**2))
    return analysis.covariance.factor @ (white + rng.standard_normal(len(white)))


def test_outsiders_that_nothing_explains_are_called_unknown() -> None:
    seed, draws = 24, 40
    print("seed", seed)
    analysis, rng = synthetic.analysis(), np.random.default_rng(seed)
    share = {
        sigma: np.mean(
            [
                synthetic.verdict(analysis, outsider(analysis, rng, sigma)).answer == "unknown"
                for _ in range(draws)
            ]
        )
        for sigma in (4.0, 8.0)
    }
    print(share)
    # an oracle finds .99 above 7 σ, a process beside the best effect .94 above 5
    assert share[8.0] >= 0.94 - 2 * np.sqrt(0.06 * 0.94 / draws)


def test_a_twin_that_was_left_out_is_called_by_the_others_name() -> None:
    analysis = synthetic.analysis()
    others = [c for c in analysis.screen.candidates if c.name != "no_self_contact"]
    screen = Screen(others, analysis.covariance)
    alone = Analysis(analysis.index, screen, synthetic.noise_std(analysis.index))
    verdict = synthetic.verdict(alone, synthetic.columns(analysis.index)["no_self_contact"])
    assert verdict.names == ("plate_friction",)


def test_the_mesh_fools_who_does_not_count_it() -> None:
    seed, draws = 25, 30
    print("seed", seed)
    rng, table = np.random.default_rng(seed), synthetic.index()
    x = synthetic.load(table)
    graded_less_ungraded = synthetic.base(table) * 0.1 * np.sin(3 * x)
    noise, nuisances = noise_matrix(table, synthetic.NOISE), synthetic.nuisances(table)
    mesh = SHARE * graded_less_ungraded
    counted = Covariance.of(noise).widened(np.column_stack([nuisances, mesh]))
    aware = Analysis(
        table, Screen(synthetic.candidates(table), counted), synthetic.noise_std(table)
    )
    residuals = counted.sample(rng, draws)  # the graded mesh's own error, and no cause
    without = synthetic.analysis()
    ignored = np.mean([synthetic.verdict(without, r).answer == "none" for r in residuals.T])
    known = np.mean([synthetic.verdict(aware, r).answer == "none" for r in residuals.T])
    print(f"none: mesh ignored {ignored}, counted {known}")
    assert known >= 0.9
    assert ignored < 0.6


def test_nuisances_wider_than_told_look_like_causes() -> None:
    """Nothing in one measurement tells the two apart: hence a laboratory's own [nuisance]."""
    seed, draws = 26, 60
    print("seed", seed)
    rng, table = np.random.default_rng(seed), synthetic.index()
    noise, told = noise_matrix(table, synthetic.NOISE), synthetic.nuisances(table)
    usual, wide = (Covariance.of(noise).widened(size * told) for size in (1, 8))
    residuals = wide.sample(rng, draws)
    std, tried = synthetic.noise_std(table), synthetic.candidates(table)

    def alarms_with(believed: Covariance) -> float:
        analysis = Analysis(table, Screen(tried, believed), std)
        return float(
            np.mean([synthetic.verdict(analysis, r).answer != "none" for r in residuals.T])
        )

    alarms = [alarms_with(believed) for believed in (usual, wide)]
    print(f"false alarms: as told {alarms[0]}, as they are {alarms[1]}")
    assert alarms[0] > 0.15
    assert alarms[1] <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / draws)


def test_a_verdict_says_what_it_is() -> None:
    analysis = synthetic.analysis()
    change = synthetic.columns(analysis.index)

    def said(residual: np.ndarray) -> Verdict:
        return synthetic.verdict(analysis, residual)

    tied = said(change["plate_friction"])
    assert tied.sentence().startswith("the cause is ")
    assert "cannot tell them apart" in tied.sentence()
    assert set(tied.names) == TIED
    assert tied.table[0].strength_sigma == pytest.approx(22.7, rel=0.1)
    nothing = said(np.zeros(44))
    assert nothing.sentence().startswith("no cause can be seen")
    doubtful = replace(nothing, probability=0.2)
    assert doubtful.sentence().startswith("no cause can be claimed (probability of none 0.20)")
    total = said(0.3 * change["set"])
    assert 0 <= total.none + total.unknown <= 1


def test_without_candidates_there_are_still_none_and_unknown() -> None:
    table = synthetic.index()
    nothing = Screen([], synthetic.covariance(table))
    analysis = Analysis(table, nothing, synthetic.noise_std(table))
    assert synthetic.verdict(analysis, np.zeros(44)).answer == "none"
    far = 40 * synthetic.noise_std(table) * np.sin(5 * synthetic.load(table))
    assert synthetic.verdict(analysis, far).answer == "unknown"


def test_what_cannot_be_seen_takes_nothing_from_none() -> None:
    table = synthetic.index()
    blind = [Candidate(f"blind {k}", (Shape(np.zeros(44)),)) for k in range(20)]
    screen = Screen([*synthetic.candidates(table), *blind], synthetic.covariance(table))
    analysis = Analysis(table, screen, synthetic.noise_std(table))
    r = synthetic.covariance(table).sample(np.random.default_rng(26), 1)[:, 0]
    assert synthetic.verdict(analysis, r).none == pytest.approx(
        synthetic.verdict(synthetic.analysis(), r).none
    )
    assert "blind 3 cannot be seen in these readings" in synthetic.verdict(analysis, r).notes


def test_weights_are_checked() -> None:
    with pytest.raises(ValueError, match="weight of none = 0"):
        HypothesisWeights(none=0)
    with pytest.raises(ValueError, match="weight of pair = -1"):
        HypothesisWeights(pair=-1)


def faint_analysis(weights: HypothesisWeights, spread: float = 0.2) -> Analysis:
    """Effects of which many an ordinary draw cannot be seen."""
    table = synthetic.index()
    faint = [
        Candidate(name, (Shape(change),), mean=0.0, spread=spread)
        for name, change in synthetic.columns(table).items()
    ]
    screen = Screen(faint, synthetic.covariance(table))
    return Analysis(table, screen, synthetic.noise_std(table), weights)


def odds_of(analysis: Analysis, whitened: np.ndarray) -> np.ndarray:
    """ln of the odds of any cause, of whitened residuals (n, m)."""
    return np.array(
        [
            analysis.findings(analysis.covariance.factor @ each).posterior.log_odds_something()
            for each in whitened.T
        ]
    )


def test_the_threshold_is_of_the_odds_that_are_compared_with_it() -> None:
    """Pairs are among these: a calibration without them alarms in more than 5 %."""
    analysis = faint_analysis(HypothesisWeights(none=0.5, single=0.1, pair=0.4, unknown=0.0))
    # the draws of the calibration itself, so that the share is exact
    draws = draw_without_visible(analysis.screen, np.random.default_rng(0), DRAWS)
    alarms = float(np.mean(odds_of(analysis, draws) > analysis.thresholds.something + 1e-9))
    assert analysis.thresholds.something > 0  # even odds, and those before measuring
    assert FALSE_ALARMS - 2 / DRAWS <= alarms <= FALSE_ALARMS


def test_what_a_simulation_gets_wrong_unseen_raises_no_more_alarms_than_noise_may() -> None:
    """An error of 1 σ in all, like any effect's change; a threshold for noise alone is exceeded."""
    seed, draws = 28, 400
    print("seed", seed)
    analysis = faint_analysis(HypothesisWeights(none=0.5, single=0.5, pair=0.0, unknown=0.0))
    rng = np.random.default_rng(seed)
    noise = np.quantile(odds_of(analysis, rng.standard_normal((44, draws))), 1 - FALSE_ALARMS)
    off = odds_of(analysis, draw_without_visible(analysis.screen, rng, draws))
    found = [float(np.mean(off > limit)) for limit in (noise, analysis.thresholds.something)]
    print(f"alarms above the threshold of noise {found[0]}, of the analysis {found[1]}")
    error = np.sqrt(FALSE_ALARMS * (1 - FALSE_ALARMS) / draws)
    assert found[0] > FALSE_ALARMS + 2 * error
    assert found[1] <= FALSE_ALARMS + 2 * error


def test_readings_that_speak_against_any_cause_raise_no_alarm() -> None:
    """Strong effects would show; their absence lowers the odds of all readings without a cause."""
    weights = HypothesisWeights()
    analysis = faint_analysis(weights, spread=50.0)
    before = np.log((weights.single + weights.pair + weights.unknown) / weights.none)
    draws = draw_without_visible(analysis.screen, np.random.default_rng(0), DRAWS)
    assert np.quantile(odds_of(analysis, draws), 1 - FALSE_ALARMS) < before
    assert analysis.thresholds.something == pytest.approx(before)
