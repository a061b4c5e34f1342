"""Whether the noise is as the laboratory believes it, and what the verdict would be if not.

Two looks. What the most probable hypothesis leaves is tested to be independent and of the size
assumed (:mod:`dolfingrip.diagnosis.inference.whiteness`). And as an unknown smooth cause explains
away what drifts, the readings are judged under noise that is larger or correlated, too: whichever
of these makes the readings more probable, averaged over all hypotheses, is what they speak for.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from dolfingrip.diagnosis.conclude import NONE, Conclusion, Fits, averaged, conclude, screen
from dolfingrip.diagnosis.inference import alternatives
from dolfingrip.diagnosis.inference.analysis import FREE
from dolfingrip.diagnosis.inference.verdict import Verdict
from dolfingrip.diagnosis.inference.whiteness import NoiseCheck, check_noise
from dolfingrip.diagnosis.noise_model import NoiseModel, part_of_run_s

DOUBTED: Final = 0.1
"""Probability of the noise as believed below which it is said to be wrong."""


@dataclass(frozen=True)
class NoiseDoubts:
    """What speaks against the noise as it was believed.

    Attributes:
        check: tests of what is left.
        models: probability of the noise as believed and of others; empty where it was not told.
        under: the verdict under each of them.
        sentences: what was found; empty where the noise is as believed.
        too_small: whether the noise is larger than believed.
        correlated: whether it drifts along runs, though it was believed independent.
    """

    check: NoiseCheck
    models: Mapping[str, float] = field(default_factory=dict)
    under: Mapping[str, Verdict] = field(default_factory=dict)
    sentences: tuple[str, ...] = ()
    too_small: bool = False
    correlated: bool = False


def noise_doubts(
    conclusion: Conclusion, fits: Fits, noise: NoiseModel, models: Mapping[str, float]
) -> NoiseDoubts:
    """Check the noise of a conclusion.

    Args:
        conclusion: under the most probable model of the noise.
        fits: of hypotheses.
        noise: as it was taken.
        models: probability of each of its models; where they are several, the verdict is an average
            over them already, and no others are tried.
    """
    check = _check(conclusion, fits)
    sentences = _notes(check)
    independent = not any(each.correlated_std for each in noise.noise.values())
    # an unknown cause that follows the noise leaves neighbours opposite, which is no drift
    left_alike = independent and any(test.name == "neighbours" for test in check.failed)
    if len(noise.others) > 1:
        best = max(models, key=lambda name: models[name])
        if models[alternatives.BELIEVED] < DOUBTED:
            sentences.insert(0, f"{_speak_for(best, models)}, over which the verdict is an average")
        larger, drifting = _wrong(models)
        return NoiseDoubts(
            check, {}, {}, tuple(sentences), check.too_small or larger,
            left_alike or (drifting and independent),
        )  # fmt: skip
    problem = conclusion.problem
    lasts_s = part_of_run_s(problem.index)
    tried = alternatives.alternatives(noise.noise, lasts_s)
    if independent:
        tried |= alternatives.in_part(noise.noise, lasts_s)
    found = {alternatives.BELIEVED: conclusion}
    for name, model in tried.items():
        if name != alternatives.BELIEVED:
            own = problem.with_noise(model)
            found[name] = conclude(own, screen(own, fits[NONE]), fits)
    _, models = averaged(found, alternatives.EVERY_PRIOR)
    best = max(models, key=lambda name: models[name])
    doubted = models[alternatives.BELIEVED] < DOUBTED
    thresholds = conclusion.analysis.thresholds
    under = {name: each.verdict(thresholds) for name, each in found.items()}
    if doubted:
        sentences.insert(0, f"{_speak_for(best, models)}; then: {under[best].sentence()}")
    larger, drifting = _wrong(models)
    return NoiseDoubts(
        check, models, under if doubted else {}, tuple(sentences),
        check.too_small or larger, left_alike or (drifting and independent),
    )  # fmt: skip


def _speak_for(best: str, models: Mapping[str, float]) -> str:
    return (
        f"the readings speak for noise that is {best} (probability {models[best]:.2f}; as believed "
        f"{models[alternatives.BELIEVED]:.2f})"
    )


def _wrong(models: Mapping[str, float]) -> tuple[bool, bool]:
    """Whether noise is larger than believed, and whether it drifts."""
    doubted = models[alternatives.BELIEVED] < DOUBTED
    drifting = (alternatives.CORRELATED, alternatives.PARTLY, alternatives.LASTING)
    larger, drifts = (
        sum(models.get(name, 0.0) for name in (*names, alternatives.BOTH)) > 0.5
        for names in ((alternatives.LARGER,), drifting)
    )
    return doubted and larger, doubted and drifts


def _notes(check: NoiseCheck) -> list[str]:
    """What tests found, what makes a verdict too sure first."""
    worst = [test.name == "neighbours" or (test.name == "size" and test.value > 1)
             for test in check.failed]  # fmt: skip
    notes = list(zip(worst, check.notes(), strict=True))
    return [note for bad, note in notes if bad] + [note for bad, note in notes if not bad]


def _check(conclusion: Conclusion, fits: Fits) -> NoiseCheck:
    """Tests of what the most probable hypothesis leaves."""
    problem, found = conclusion.problem, conclusion.posterior
    names = [score.name for score in conclusion.scores]
    key = NONE
    if names and found.singles.max() > found.none:
        key = frozenset([names[int(found.singles.argmax())]])
    if names and found.pairs.max(initial=0.0) > max(found.none, found.singles.max()):
        e, f = np.unravel_index(int(found.pairs.argmax()), found.pairs.shape)
        key = frozenset([names[int(e)], names[int(f)]])
    catalogue = max(found.none, found.singles.max(initial=0.0), found.pairs.max(initial=0.0))
    smooth = max(found.unknown, found.beside.max(initial=0.0))
    if key in fits and catalogue >= smooth:
        fit = fits[key]
        covariance = fit.widened(problem, FREE)
        return check_noise(problem.index, fit.residual(problem.value), covariance)
    residual = fits[NONE].residual(problem.value)
    return conclusion.analysis.check(residual, conclusion.analysis.findings(residual))
