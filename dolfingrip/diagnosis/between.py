"""Strong effects where nothing is fitted by simulation: between the screen's simulations.

A strong effect is not linear in its strength, and a secant at another strength leaves many standard
deviations of its change, which a smooth unknown cause explains better than any effect does. So the
screen judges strong effects at the best place of their surface
(:mod:`dolfingrip.diagnosis.surface`), and counts that a surface is off what a simulation there
would give by a part of the change: :data:`OFF`, smooth in the load, of any sign in each channel,
branch and cycle. What is left beyond that speaks for an unknown cause.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from dolfingrip.diagnosis.conclude import NONE, Fits, conclude
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.analysis import Analysis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.screen import Score
from dolfingrip.diagnosis.inference.unknown import smooth_changes
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.remodulated import remodulated
from dolfingrip.diagnosis.search import BEHIND, PART
from dolfingrip.extensions.index import effect

STRONG: Final = 3.0
"""Strength (σ) of the leading effect from which on surfaces replace secants."""

OFF: Final = 0.15
"""Standard deviation of what a surface is off by at most, as part of the effect's change."""

SIZES: Final = (0.1, 0.3, 1.0)
"""Parts of that, each as likely before measuring; the one that the readings ask for is taken. Else
a surface that is hardly off would lose to an unknown cause, by all that its error could be."""

UNTRIED: Final = 0.3
"""The same where parameters of the effect are tried at one value alone."""

ROUGH: Final = 0.3
"""Of that part, what differs from reading to reading."""

MOST: Final = 6
"""Effects that are judged on their surfaces."""


def between(fitter: Fitter, analysis: Analysis, none: Hypothesis) -> Fits:
    """The base model, linear effects beside their own modulus, and strong ones on their surfaces.

    Args:
        fitter: of the problem; no simulation is made.
        analysis: the screen.
        none: the base model's fit.

    Returns:
        None of the latter where no effect is strong, or secants serve: one effect or none explains
        the readings more probably than two, or an unknown cause, do.
    """
    found: dict[frozenset[str], Hypothesis] = {NONE: none}
    first = conclude(fitter.problem, analysis, found)
    more = remodulated(fitter, first.scores, none)
    if more:
        found |= more
        first = conclude(fitter.problem, analysis, found)
    scores = {score.name: score for score in first.scores}
    if first.posterior.at_most_one >= 0.5:
        return found
    for name in _strong(first.scores)[:MOST]:
        fit = on_surface(fitter, scores[name], none)
        if fit is not None:
            found[frozenset([name])] = fit
    return found


def _strong(scores: Sequence[Score]) -> list[str]:
    """Effects that explain about as much as the leading one, which is strong; it comes first."""
    order = sorted((s for s in scores if s.visible), key=lambda score: -score.log_evidence)
    if not order or order[0].strength_sigma < STRONG:
        return []
    best = order[0].log_evidence
    return [s.name for s in order if s.log_evidence > min(PART * best, best - BEHIND)]


def on_surface(fitter: Fitter, score: Score, none: Hypothesis) -> Hypothesis | None:
    """An effect at the best place of its surface; None where it has none."""
    problem = fitter.problem
    point = fitter.on_surface(score, none)
    if point is None:
        return None
    beside, readings = point.beside, point.readings
    found = replace(
        beside,
        effects=(score.name,),
        parameters=(*beside.parameters, *point.parameters),
        zeta=point.zeta,
        readings=readings,
        jacobian=point.jacobian,
        model=None,
        overrides=(),
        correction=-math.log(len(SIZES)),
    )
    error = surface_error(problem, score.name, readings - none.readings)
    sized = [replace(found, error=size * error) for size in SIZES]
    return max(sized, key=lambda fit: fit.log_evidence(problem))


def surface_error(problem: Problem, name: str, change: Vector) -> Matrix:
    """Columns of one standard deviation of what a surface is off by at most, shape (n, m).

    Of the change that the base model at its best modulus does not make: much of what an elastic law
    changes is a modulus. Smooth in the load, by a part of the change at each reading and by the
    same part of its usual size in the channel, as where a change passes 0 its error does not; and a
    little from reading to reading, as where a branch turns.
    """
    part = UNTRIED if effect(name).alike else OFF
    usual = np.zeros(len(change))
    blocks = problem.index.groupby(["experiment", "channel"], sort=False).indices
    for rows in blocks.values():
        usual[rows] = np.sqrt(np.mean(change[rows] ** 2))
    smooth = smooth_changes(problem.index)
    return part * np.hstack(
        [change[:, None] * smooth, usual[:, None] * smooth, np.diag(ROUGH * usual)]
    )
