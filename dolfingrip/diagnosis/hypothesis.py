"""A hypothesis at its fit: readings and their derivatives; the rest is closed form from there.

At a fit ζ* the readings are about y* + J (ζ − ζ*), so that with standard normal ζ

    ln Z = ln N(y − y* + J ζ*; 0, C + J Jᵀ),

which is Laplace's evidence there. Other noise, or a part of the readings, need no new simulation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.evidence import INTERVAL
from dolfingrip.diagnosis.inference.laplace import Estimate, to_values
from dolfingrip.diagnosis.model import EffectModel, FreeParameter
from dolfingrip.diagnosis.problem import Problem


@dataclass(frozen=True)
class LinearPart:
    """An effect that changes the readings in proportion to its strength.

    Attributes:
        effect: its name.
        label: of its shape, among those that it is tried in.
        spread: strength, by the ordinary one, for each unit of its standard normal number.
    """

    effect: str
    label: str
    spread: float


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """No effect, one or several, at the parameters that fit best.

    Attributes:
        effects: their names; none for the base model with its nuisances.
        parameters: that were free.
        zeta: their standard normal numbers at the fit, shape (p,).
        readings: y*, shape (n,).
        jacobian: J, of the readings by ζ, shape (n, p).
        evaluations: simulations of the whole measurement that it took.
        model: gives readings at other parameters; None where the effect is linear.
        overrides: the configuration at the fit, as with ``--set``.
        correction: to ln Z, where a strength has one sign.
        error: columns of one standard deviation of what the readings y* may be off by where they
            were not simulated, shape (n, m); None where they were.
        beside: of linear effects, the fit that they are added to; its parameters come first.
        linear: those effects, in the order of the other parameters.
    """

    effects: tuple[str, ...]
    parameters: tuple[FreeParameter, ...]
    zeta: Vector
    readings: Vector
    jacobian: Matrix
    evaluations: int = 0
    model: EffectModel | None = field(default=None, repr=False)
    overrides: tuple[str, ...] = ()
    correction: float = 0.0
    error: Matrix | None = field(default=None, repr=False)
    beside: Hypothesis | None = field(default=None, repr=False)
    linear: tuple[LinearPart, ...] = ()

    @property
    def values(self) -> list[float]:
        """Of the parameters, at the fit."""
        return to_values((each.prior for each in self.parameters), self.zeta)

    @property
    def by_key(self) -> Mapping[str, float]:
        """The same by key."""
        return dict(zip((each.key for each in self.parameters), self.values, strict=True))

    def residual(self, value: Vector) -> Vector:
        """Measured less what is expected with ζ = 0 along the tangent, shape (n,)."""
        return np.asarray(value - self.readings + self.jacobian @ self.zeta)

    def covariance(self, problem: Problem) -> Covariance:
        """C + J Jᵀ, and what the readings may be off by."""
        return self.widened(problem, 1.0)

    def widened(self, problem: Problem, free: float) -> Covariance:
        """The same with priors of all parameters ``free`` times as wide."""
        columns = free * self.jacobian
        if self.error is not None:
            columns = np.hstack([columns, self.error])
        return problem.covariance.widened(columns) if columns.size else problem.covariance

    def log_evidence(self, problem: Problem) -> float:
        """ln Z."""
        own = self.covariance(problem).log_density(self.residual(problem.value))
        return own + self.correction

    def std(self, problem: Problem) -> Vector:
        """Standard deviations of ζ after measuring, shape (p,)."""
        white = problem.covariance.whiten(self.jacobian)
        return np.sqrt(np.diag(np.linalg.inv(np.eye(white.shape[1]) + white.T @ white)))

    def estimates(self, problem: Problem) -> list[Estimate]:
        """Parameters with 90 % intervals."""
        return [
            Estimate(
                p.prior.at(z),
                max(p.prior.at(z - INTERVAL * s), p.low),
                min(p.prior.at(z + INTERVAL * s), p.high),
                float(s),
            )
            for p, z, s in zip(self.parameters, self.zeta, self.std(problem), strict=True)
        ]

    def fitted_nuisances(self, problem: Problem) -> dict[str, float]:
        """Linear nuisances beside the fit, by their standard deviations."""
        columns = np.hstack([self.jacobian, problem.nuisances])
        white = problem.error_covariance.whiten(
            np.column_stack([self.residual(problem.value), columns])
        )
        information = np.eye(columns.shape[1]) + white[:, 1:].T @ white[:, 1:]
        zeta = np.linalg.solve(information, white[:, 1:].T @ white[:, 0])
        names = [each.name for each in problem.linear_nuisances()]
        own = zeta[self.jacobian.shape[1] :]
        return {name: float(z) for name, z in zip(names, own, strict=True)}

    def predicted(
        self, problem: Problem, known: np.ndarray, others: Sequence[Matrix] = ()
    ) -> Vector:
        """Expected readings, shape (n,), where only those ``known`` (n,) have been measured.

        Parameters and nuisances are fitted to these; what mesh and laws get wrong is left.

        Args:
            problem: with noise and nuisances.
            known: which readings are used.
            others: further columns of one standard deviation, shape (n, k) each.
        """
        columns = np.hstack([self.jacobian, problem.nuisances, *others])
        residual = self.residual(problem.value)
        block = np.ix_(known, known)
        noise = problem.error_covariance.matrix[block]
        seen = columns[known]
        covariance = Covariance.of(noise + seen @ seen.T)
        back = covariance.whiten(np.column_stack([residual[known], seen]))
        strength = back[:, 1:].T @ back[:, 0]
        return np.asarray(self.readings - self.jacobian @ self.zeta + columns @ strength)
