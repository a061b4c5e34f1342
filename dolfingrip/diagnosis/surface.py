"""An effect between the values that it was tried at: where a fit starts, and what it may reach.

The screen's simulations stand on a few values of an effect's parameters: the ordinary strength, and
each other parameter some way to either side. Between them the change by the effect is

    Δ(θ) = s(a) [D₀ + Σ_k (D_k(θ_k) − D₀)],    s = (a − neutral) / (ordinary − neutral),

D₀ the change at the ordinary values, D_k a parabola through the changes along parameter k in its
standard normal number. Where amplitudes were tried one by one, their changes are added. With all
moduli c times as large it is Δ(p/c), and c Δ(p/c) of a force (Δ(p/c) along the tangent by p).
No simulation is needed, so a fit on this surface tells where the simulated one best begins.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from scipy.optimize import least_squares

from dolfingrip.channels import CHANNELS
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.laplace import MARGIN, to_values, zeta_bounds
from dolfingrip.diagnosis.model import SCALE, FreeParameter
from dolfingrip.diagnosis.problem import Problem
from dolfingrip.diagnosis.simulation.secants import Candidate
from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import effect
from dolfingrip.sections.tables import assigned

BEYOND: Final = 0.5
"""How far beyond the values that were tried the surface goes on, in standard deviations."""

STARTS: Final = 4
"""Shapes that a fit on the surface starts from, the most probable ones."""

ALIKE: Final = 1e-6
"""Difference of two values, in standard deviations, that is rounding."""


@dataclass(frozen=True)
class SurfacePoint:
    """The best place on a surface.

    Attributes:
        zeta: of the parameters that were free beside the surface's, and of its own, shape (p,).
        parameters: the surface's own.
        values: of these.
        change: of the readings by the effect there, shape (n,).
        jacobian: of all readings by ``zeta`` there, shape (n, p).
        log_evidence: ln of the readings' density there, by Laplace's method.
        beside: the hypothesis along whose tangent the other parameters moved.
    """

    zeta: Vector
    parameters: tuple[FreeParameter, ...]
    values: tuple[float, ...]
    change: Vector
    jacobian: Matrix
    log_evidence: float
    beside: Hypothesis

    @property
    def readings(self) -> Vector:
        """Of the other hypothesis and the effect together, shape (n,)."""
        count = len(self.beside.parameters)
        tangent = self.beside.jacobian @ (self.zeta[:count] - self.beside.zeta)
        return np.asarray(self.beside.readings + tangent + self.change)


class SecantSurface:
    """The change by an effect as a function of its parameters.

    Attributes:
        close: whether it is nearly what a simulation gives between the values that were tried.

    Args:
        problem: the readings.
        candidate: with the changes that were simulated.
        parameters: of the effect, that a fit finds.
    """

    close: ClassVar[bool] = False

    def __init__(
        self, problem: Problem, candidate: Candidate, parameters: Sequence[FreeParameter]
    ) -> None:
        self.parameters = tuple(parameters)
        self._problem = problem
        self._name = candidate.name
        self.follow(np.array([problem.take(change) for change in candidate.shapes]))
        self.places = np.array([self._zeta(texts) for texts in candidate.overrides])
        own = effect(candidate.name).neutral
        self._amplitudes = [
            k for k, p in enumerate(self.parameters) if p.key.rpartition(".")[2] in own
        ]
        self._neutral = [_number(own[self.parameters[k].key.rpartition(".")[2]])
                         for k in self._amplitudes]  # fmt: skip
        self._middle = self._values(self.places[0])

    def effect(self, zeta: Vector) -> Effect:
        """The effect at these standard normal numbers, shape (p,)."""
        kind, values = effect(self._name), {}
        for parameter, value in zip(self.parameters, self._values(zeta), strict=True):
            key = parameter.key.rpartition(".")[2]
            values[key] = (value,) if isinstance(kind.model_fields[key].default, tuple) else value
        return kind.model_validate(values)

    def follow(self, changes: Matrix) -> None:
        """Go through ``changes`` of the readings at the places that were tried, (shapes, n)."""
        self.changes = changes
        self._slopes = np.array([_by_modulus(self._problem, change) for change in changes])

    def _zeta(self, texts: Sequence[str]) -> list[float]:
        told = numbers(texts)
        return [
            p.prior.zeta(min(max(told.get(p.key, p.prior.mean), p.low), p.high))
            for p in self.parameters
        ]

    def _values(self, zeta: Sequence[float] | Vector) -> list[float]:
        return to_values((p.prior for p in self.parameters), zeta)

    def change(self, zeta: Vector, factor: float = 1.0) -> Vector:
        """Of the readings, shape (n,).

        Args:
            zeta: standard normal numbers, shape (p,).
            factor: of all moduli.
        """
        weights = self._weights(zeta)
        return np.asarray(weights @ self.changes + math.log(factor) * (weights @ self._slopes))

    def _weights(self, zeta: Vector) -> Vector:
        """Of the changes that were tried, shape (shapes,)."""
        found = np.zeros(len(self.changes))
        if len(self._amplitudes) == 1:
            found[0] = 1.0
            for k in range(len(self.parameters)):
                found += self._along(k, float(zeta[k]))
                found[0] -= 1.0
            return np.asarray(self._strength(zeta, 0) * found)
        alone = [self._alone(k) for k in self._amplitudes]
        for place, row in enumerate(alone):
            if row is not None:
                found[row] += self._strength(zeta, place)
        if all(row is None for row in alone):
            found[0] = self._strength(zeta, 0)
        return found

    def _strength(self, zeta: Vector, place: int) -> float:
        if not self._amplitudes:
            return 1.0
        k, rest = self._amplitudes[place], self._neutral[place]
        return (self._values(zeta)[k] - rest) / (self._middle[k] - rest)

    def _along(self, k: int, zeta: float) -> Vector:
        """Weights of a parabola through what was tried of one parameter alone, shape (shapes,)."""
        others = np.delete(self.places, k, axis=1)
        rows = np.flatnonzero((np.abs(others - others[0]) < ALIKE).all(axis=1))
        at, where = np.unique(self.places[rows, k], return_index=True)
        rows = rows[where]
        x = min(max(zeta, at[0] - BEYOND), at[-1] + BEYOND)
        found = np.zeros(len(self.changes))
        for i, row in enumerate(rows):
            found[row] = math.prod((x - at[j]) / (at[i] - at[j]) for j in range(len(at)) if j != i)
        return found

    def _alone(self, k: int) -> int | None:
        """The shape that has this amplitude alone."""
        rest = [other for other in self._amplitudes if other != k]
        neutral = dict(zip(self._amplitudes, self._neutral, strict=True))
        for row, place in enumerate(self.places):
            values = self._values(place)
            if all(abs(values[other] - neutral[other]) <= _tolerance(self.parameters[other])
                   for other in rest):  # fmt: skip
                return row
        return None

    def best(self, problem: Problem, beside: Hypothesis, starts: Sequence[int]) -> SurfacePoint:
        """The most probable place, beside a hypothesis along its tangent.

        Args:
            problem: the readings.
            beside: whose parameters are free, too.
            starts: numbers of the shapes to start from, the most probable first.
        """
        first = len(beside.parameters)
        scaled = [p.key for p in beside.parameters][:1] == [SCALE]
        prior = beside.parameters[0].prior if scaled else None
        every = [*beside.parameters, *self.parameters]
        low, high = zeta_bounds([p.prior for p in every], [(p.low, p.high) for p in every])
        white = problem.covariance.whiten(
            np.column_stack([beside.residual(problem.value), beside.jacobian])
        )

        def change(zeta: Vector) -> Vector:
            factor = 1.0 if prior is None else prior.at(float(zeta[0]))
            return self.change(zeta[first:], factor)

        def misfit(zeta: Vector) -> Vector:
            change_white = problem.covariance.whiten(change(zeta))
            left = white[:, 0] - white[:, 1:] @ zeta[:first] - change_white
            return np.concatenate([left, zeta])

        found = []
        for row in list(starts)[:STARTS]:
            start = np.clip(np.append(beside.zeta, self.places[row]), low + MARGIN, high - MARGIN)
            found.append(least_squares(misfit, start, bounds=(low, high), x_scale="jac"))
        best = min(found, key=lambda each: each.cost)
        n = len(problem.value)
        information = np.eye(len(best.x)) + best.jac[:n].T @ best.jac[:n]
        log = -best.cost - 0.5 * float(np.linalg.slogdet(information)[1])
        log -= 0.5 * (problem.covariance.logdet + n * math.log(2 * math.pi))
        own = tuple(self._values(best.x[first:]))
        slopes = -np.asarray(problem.covariance.factor @ best.jac[:n])
        return SurfacePoint(
            best.x, self.parameters, own, change(best.x), slopes, log, beside
        )  # fmt: skip


def _by_modulus(problem: Problem, change: Vector) -> Vector:
    """Derivative of a change by the logarithm of all moduli, shape (n,)."""
    index = problem.index.reset_index(drop=True)
    found = np.zeros(len(change))
    for (experiment, column, *_), rows in index.groupby(
        ["experiment", "channel", "run", "cycle", "branch"], sort=False
    ):
        at = rows.index.to_numpy()
        if experiment != "coupon":
            load = rows["pressure_kPa"].to_numpy()
            order = np.argsort(load, kind="stable")
            if len(at) > 2 and (np.diff(load[order]) > 0).all():
                by_load = np.gradient(change[at][order], load[order])
                found[at[order]] = -load[order] * by_load
        if CHANNELS[column].in_proportion:
            found[at] += change[at]
    return found


def numbers(overrides: Sequence[str]) -> Mapping[str, float]:
    """Numbers by key, of a list its first."""
    found = {}
    for text in overrides:
        key, value = assigned(text)
        value = value[0] if isinstance(value, list) else value
        if not isinstance(value, bool | str):
            found[key] = float(value)
    return found


def _number(value: object) -> float:
    return float(value[0] if isinstance(value, list | tuple) else value)  # type: ignore[arg-type]


def _tolerance(parameter: FreeParameter) -> float:
    """Values are kept off their bounds by a part of the spread."""
    return 0.01 * parameter.prior.spread
