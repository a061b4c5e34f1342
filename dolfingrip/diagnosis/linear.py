"""Effects that change the readings in proportion to their strength: closed forms beside a fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.special import log_ndtr

from dolfingrip.diagnosis.hypothesis import Hypothesis, LinearPart
from dolfingrip.diagnosis.inference.screen import Score
from dolfingrip.diagnosis.model import FreeParameter
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation.secants import Candidate
from dolfingrip.diagnosis.step import hypothesis_at, visit
from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.index import effect
from dolfingrip.sections.tables import assigned

STRENGTH: Final = "strength of "
"""Begins the key of a strength by the ordinary one."""

STEPS: Final = 12
"""Of a fit of modulus, walls and strength; most take two to five."""
LONGEST: Final = 0.7
"""Of these, in standard deviations of modulus and walls before measuring."""
SETTLED: Final = 0.02
"""Step that is not worth another one."""


def with_linear(
    problem: Problem,
    names: tuple[str, ...],
    beside: Hypothesis,
    linear: Sequence[tuple[Score, Candidate]],
) -> Hypothesis:
    """``beside`` with effects that change the readings in proportion to their strength."""
    columns, parameters, overrides = [], list(beside.parameters), list(beside.overrides)
    for score, each in linear:
        columns.append(problem.take(each.shapes[score.shape]) * each.spread)
        low = 0.0 if each.one_sided else -math.inf
        prior = Prior(0.0, each.spread, "by the ordinary strength")
        parameters.append(FreeParameter(f"{STRENGTH}{each.name}", prior, low, math.inf))
    jacobian = np.column_stack([beside.jacobian, *columns])
    white = problem.covariance.whiten(np.column_stack([beside.residual(problem.value), jacobian]))
    information = np.eye(jacobian.shape[1]) + white[:, 1:].T @ white[:, 1:]
    zeta = np.linalg.solve(information, white[:, 1:].T @ white[:, 0])
    std = np.sqrt(np.diag(np.linalg.inv(information)))
    correction = 0.0
    first = len(beside.parameters)
    for number, (score, each) in enumerate(linear, first):
        if each.one_sided:
            correction += float(log_ndtr(zeta[number] / std[number])) + math.log(2)
            zeta[number] = max(zeta[number], 0.0)
        strength = float(zeta[number]) * each.spread
        overrides += _scaled(each.name, each.overrides[score.shape], strength)
    readings = beside.readings + jacobian @ (zeta - np.append(beside.zeta, np.zeros(len(linear))))
    parts = [LinearPart(each.name, each.labels[score.shape], each.spread) for score, each in linear]
    return Hypothesis(
        names, tuple(parameters), np.asarray(zeta, dtype=float), readings, jacobian,
        beside.evaluations, None,
        tuple(overrides), correction, beside=beside, linear=tuple(parts),
    )  # fmt: skip


def beside_own_modulus(
    problem: Problem, none: Hypothesis, score: Score, candidate: Candidate
) -> Hypothesis:
    """An effect with modulus and walls beside it, fitted together by Gauss and Newton.

    Without an effect the base model may fit best at a modulus and walls that are far from the
    truth: an angle that is read 20 % low is a stiffer finger, nearly. The tangent there does not
    reach to the modulus that the effect brings back. The base model needs no simulation at another
    modulus or with other walls (:mod:`dolfingrip.diagnosis.simulation.modulus`, ``walls``).

    Args:
        problem: the readings.
        none: the base model's fit.
        score, candidate: the effect in the screen.

    Returns:
        The effect along the tangent of ``none`` where the base model would need simulations, or
        where the strength has the other sign than the effect.
    """
    name = (score.name,)
    first = with_linear(problem, name, none, [(score, candidate)])
    if none.model is None or not none.model.in_closed_form or not none.parameters:
        return first
    fit, zeta = first, none.zeta
    for _ in range(STEPS):
        step = np.clip(fit.zeta[:-1] - zeta, -LONGEST, LONGEST)
        if fit.zeta[-1] == 0.0 or float(np.abs(step).max()) < SETTLED:
            break
        zeta = zeta + step
        place = visit(problem, none.model.evaluate, none.model, zeta)
        here = hypothesis_at((), none.model, place)
        fit = with_linear(problem, name, here, [(score, candidate)])
    return first if fit.zeta[-1] == 0.0 else fit


def _scaled(name: str, overrides: Sequence[str], strength: float) -> list[str]:
    """Overrides with the amplitudes at a strength by the ordinary one."""
    found = []
    for text in overrides:
        key, value = assigned(text)
        neutral = effect(name).neutral.get(key.rpartition(".")[2])
        if neutral is None or isinstance(value, bool | str):
            found.append(text)
        elif isinstance(value, list):
            rest = [float(entry) for entry in neutral]
            found.append(
                f"{key}={[a + strength * (b - a) for a, b in zip(rest, value, strict=True)]}"
            )
        else:
            found.append(f"{key}={neutral + strength * (value - neutral)!r}")
    return found
