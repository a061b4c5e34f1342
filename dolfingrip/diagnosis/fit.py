"""Nonlinear fits: the modulus and the parameters of effects, with nuisances free."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from scipy.special import log_ndtr

from dolfingrip.config import Config
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.laplace import FTOL, slope, to_value, zeta_bounds
from dolfingrip.diagnosis.inference.laplace import fit as laplace_fit
from dolfingrip.diagnosis.inference.screen import Score
from dolfingrip.diagnosis.model import (
    EffectModel,
    FitFailure,
    FreeParameter,
    can_be_fitted,
    free_parameters,
)
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation import meshes
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.secants import Candidate
from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.index import effect
from dolfingrip.sections.tables import assigned

MOST_EVALUATIONS: Final = 20
"""Simulations of the whole measurement in a fit; each is one step of the least squares. Most fits
take four to eight; what ends earlier than that would be said to explain less than it does."""

WEAKEST, STRONGEST = 0.3, 3.0
"""Range of the strength that a fit starts at, by the ordinary one."""

GRADED_STEPS: Final = 2
"""Most simulations on the graded mesh, which start where the fit on the ungraded one ended."""

ROUGH: Final = 5e-3
"""Relative change of the sum of squares below which the search on the ungraded mesh ends: less than
one in the log likelihood, as steps on the graded mesh follow."""

SMALL_STEP: Final = 0.7
"""A step, in standard deviations, along which the readings are linear enough."""

BAD: Final = 3.0
"""What stands for the readings where a simulation fails: these are off by so many times."""


@dataclass
class Fitter:
    """Fits hypotheses to a problem.

    Attributes:
        problem: the readings.
        workers: where simulations are computed and kept.
        say: told what is being done.
        failures: fits that were given up, a sentence each.
    """

    problem: Problem
    workers: Workers
    say: Callable[[str], None]
    failures: list[str] = field(default_factory=list)

    def none(self) -> Hypothesis:
        """The base model, its modulus fitted."""
        base = self.problem.base
        model = EffectModel(
            base.measurement, base.config, self.workers, self.problem.scale,
            base=base.simulated, scales=base.scales,
        )  # fmt: skip
        return self._fitted((), model, None)

    def effects(self, scores: Sequence[Score], none: Hypothesis) -> Hypothesis | None:
        """One effect or several; None where no simulation of it succeeds.

        Args:
            scores: of the effects in the screen, which say where to start.
            none: fit without an effect.
        """
        found = [self._candidate(score.name) for score in scores]
        config = self._config()
        simulated = [
            (score, each)
            for score, each in zip(scores, found, strict=True)
            if can_be_fitted(each.name, each.overrides[score.shape], config)
        ]
        linear = [
            (score, each)
            for score, each in zip(scores, found, strict=True)
            if (score, each) not in simulated
        ]
        names = tuple(score.name for score in scores)
        if not simulated:
            return self._linear(names, none, linear)
        parameters: list[FreeParameter] = []
        held: list[str] = []
        start: list[float] = []
        for score, each in simulated:
            own = free_parameters(each.name, each.overrides[score.shape], config)
            values = _numbers(each.overrides[score.shape])
            parameters += own
            held += [
                text for text in each.overrides[score.shape]
                if text.partition("=")[0] not in {p.key for p in own}
            ]  # fmt: skip
            strength = min(max(abs(score.amplitude.mean), WEAKEST), STRONGEST)
            start += [_started(each.name, p, values.get(p.key), strength) for p in own]
        base = self.problem.base
        model = EffectModel(
            base.measurement, base.config, self.workers, self.problem.scale, parameters, held
        )
        first = [*none.values[: int(self.problem.scale is not None)], *start]
        self.say(f"fitting {' with '.join(names)}")
        try:
            hypothesis = self._fitted(names, model, first)
        except FitFailure as failure:
            self.failures.append(f"{' with '.join(names)} could not be fitted: {failure}")
            return None
        return self._linear(names, hypothesis, linear) if linear else hypothesis

    def _config(self) -> Config:
        tests = self.problem.measurement.tests
        return tests[0].setup.applied(self.problem.base.config)

    def _candidate(self, name: str) -> Candidate:
        return next(each for each in self.problem.base.candidates if each.name == name)

    def _fitted(
        self, names: tuple[str, ...], model: EffectModel, start: Sequence[float] | None
    ) -> Hypothesis:
        """Least squares on the ungraded mesh where there is one, then steps on the graded one."""
        base = self.problem.base
        flat = meshes.ungraded(self._config()) if model.effects else ()
        if not flat or not base.mesh.size:
            zeta = self._least_squares(model, start, 0.0 * self.problem.value, FTOL)
            return self._at(names, model, zeta)
        rough = replace(model, held=(*model.held, *flat), _known={})
        offset: Vector = self.problem.take(np.nan_to_num(base.mesh[:, 0]) / meshes.SHARE)
        zeta = self._least_squares(rough, start, offset, ROUGH)
        self.say(f"{' with '.join(names)}: on the graded mesh")
        for _ in range(GRADED_STEPS):
            found = self._stepped(self._at(names, model, zeta))
            step = (found.zeta - zeta) / found.std(self.problem)
            zeta = found.zeta
            if np.abs(step).max() < SMALL_STEP:
                break
        return replace(found, evaluations=model.count + rough.count)

    def _least_squares(
        self, model: EffectModel, start: Sequence[float] | None, offset: Vector, ftol: float
    ) -> Vector:
        """ζ of the most probable parameters; ``offset`` is added to the readings, shape (n,)."""
        problem, parameters = self.problem, model.parameters
        covariance, measured = problem.covariance, problem.value - offset

        def residual(values: Sequence[float]) -> Vector:
            try:
                return covariance.whiten(measured - problem.take(model.evaluate(values)[0]))
            except FitFailure:
                return BAD * covariance.whiten(measured)

        def jacobian(values: Sequence[float]) -> Matrix:
            return -covariance.whiten(self._rows(model.evaluate(values)[1]))

        if not parameters:
            return np.zeros(0)
        found = laplace_fit(
            residual, [each.prior for each in parameters], covariance.logdet, start, jacobian,
            most_evaluations=MOST_EVALUATIONS,
            bounds=[(each.low, each.high) for each in parameters], ftol=ftol,
        )  # fmt: skip
        return found.zeta

    def _at(self, names: tuple[str, ...], model: EffectModel, zeta: Vector) -> Hypothesis:
        """The hypothesis at given parameters."""
        parameters = model.parameters
        pairs = [(p.prior, float(z)) for p, z in zip(parameters, zeta, strict=True)]
        values = [to_value(*pair) for pair in pairs]
        readings, slopes = model.evaluate(values)
        by_zeta = np.array([slope(*pair) for pair in pairs])
        return Hypothesis(
            names, tuple(parameters), zeta, self.problem.take(readings),
            self._rows(slopes) * by_zeta, model.count, model, model.overrides(values),
        )  # fmt: skip

    def _stepped(self, fit: Hypothesis) -> Hypothesis:
        """One step of Gauss and Newton along the tangent, within the bounds."""
        white = self.problem.covariance.whiten(
            np.column_stack([fit.residual(self.problem.value), fit.jacobian])
        )
        information = np.eye(white.shape[1] - 1) + white[:, 1:].T @ white[:, 1:]
        best = np.linalg.solve(information, white[:, 1:].T @ white[:, 0])
        low, high = zeta_bounds(
            [p.prior for p in fit.parameters], [(p.low, p.high) for p in fit.parameters]
        )
        zeta: Vector = np.asarray(np.clip(best, low, high), dtype=float)
        values = [to_value(p.prior, float(z)) for p, z in zip(fit.parameters, zeta, strict=True)]
        assert fit.model is not None
        return replace(
            fit, zeta=zeta, readings=fit.readings + fit.jacobian @ (zeta - fit.zeta),
            overrides=fit.model.overrides(values),
        )  # fmt: skip

    def _rows(self, matrix: Matrix) -> Matrix:
        return np.asarray(matrix[self.problem.kept])

    def _linear(
        self,
        names: tuple[str, ...],
        beside: Hypothesis,
        linear: Sequence[tuple[Score, Candidate]],
    ) -> Hypothesis:
        """``beside`` with effects that change the readings in proportion to their strength."""
        problem = self.problem
        columns, parameters, overrides = [], list(beside.parameters), list(beside.overrides)
        for score, each in linear:
            columns.append(problem.take(each.shapes[score.shape]) * each.spread)
            low = 0.0 if each.one_sided else -math.inf
            prior = Prior(0.0, each.spread, "by the ordinary strength")
            parameters.append(FreeParameter(f"{STRENGTH}{each.name}", prior, low, math.inf))
        jacobian = np.column_stack([beside.jacobian, *columns])
        white = problem.covariance.whiten(
            np.column_stack([beside.residual(problem.value), jacobian])
        )
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
        readings = beside.readings + jacobian @ (
            zeta - np.append(beside.zeta, np.zeros(len(linear)))
        )
        return Hypothesis(
            names, tuple(parameters), np.asarray(zeta, dtype=float), readings, jacobian,
            beside.evaluations, None,
            tuple(overrides), correction,
        )  # fmt: skip


STRENGTH: Final = "strength of "
"""Begins the key of a strength by the ordinary one."""


def _numbers(overrides: Sequence[str]) -> Mapping[str, float]:
    """Numbers by key, of a list its first."""
    found = {}
    for text in overrides:
        key, value = assigned(text)
        value = value[0] if isinstance(value, list) else value
        if not isinstance(value, bool | str):
            found[key] = float(value)
    return found


def _started(name: str, parameter: FreeParameter, ordinary: float | None, strength: float) -> float:
    """Where a fit starts: at the screen's strength, within the bounds."""
    value = parameter.prior.mean if ordinary is None else ordinary
    neutral = effect(name).neutral.get(parameter.key.rpartition(".")[2])
    if neutral is not None and ordinary is not None:
        rest = float(neutral[0] if isinstance(neutral, list | tuple) else neutral)
        value = rest + strength * (ordinary - rest)
    return min(max(value, parameter.low), parameter.high)


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
