"""A Gaussian process that learns from values and gradients, and tells how unsure it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize
from scipy.stats import norm, qmc

Floats = npt.NDArray[np.float64]


NUGGET: Final = 2e-6
"""Part of the variance that is added to the diagonal. Solutions are converged, but pairs of contact
that come and go leave values and gradients rough below any length."""

SHORTEST, LONGEST = 0.1, 10.0
"""Correlation lengths, in ranges of the inputs."""

TYPICAL, SPREAD = 1.0, 0.5
"""Median and standard deviation of the lengths' log-normal prior."""

MEMBERS: Final = 16
"""Number of sets of lengths in the ensemble."""

STEP: Final = 0.05
"""Step of the logarithms of the lengths, for the likelihood's curvature."""


@dataclass(frozen=True, slots=True)
class _Member:
    """The process for one set of lengths.

    Attributes:
        lengths: shape (d,).
        factor: of the covariance of what was observed, for a variance of 1.
        weights: shape (observed,), inverse covariance times what was observed.
        variance: of what was observed.
        unlikely: negative logarithm of the lengths' posterior density, but for a constant.
    """

    lengths: Floats
    factor: tuple[Floats, bool]
    weights: Floats
    variance: float
    unlikely: float


class GradientProcess:
    """An ensemble of Gaussian processes with Matérn 5/2 covariance over scaled inputs.

    Derivatives of a Gaussian process are jointly Gaussian with it, so gradients are observations
    like values (Rasmussen & Williams, Gaussian Processes for Machine Learning, 2006, sections 4.2,
    5.4 and 9.4). Contact starts and ends where a design changes, so a reading has no more than two
    derivatives by it; a covariance with more is surer than it may be. The members' lengths are
    drawn from their posterior by Laplace's approximation and weighted by importance. Deviations
    are multiplied by what leaving out each design, with its gradient, finds
    (:attr:`calibration`).

    Args:
        inputs: shape (n, d), each about 0 to 1.
        values: shape (n,).
        slopes: shape (n, d); None: values alone.
        seed: of the Sobol sequence of lengths.

    Attributes:
        lengths: correlation length along each input, the likeliest.
        calibration: root mean square of the left-out errors in deviations, at least 1.
    """

    def __init__(
        self,
        inputs: Floats,
        values: Floats,
        slopes: Floats | None = None,
        seed: int = 1,
    ) -> None:
        self._seed = seed
        self._x, self._mean = np.asarray(inputs, dtype=float), float(np.mean(values))
        observed = np.asarray(values, dtype=float) - self._mean
        self._with_slopes = slopes is not None
        if slopes is not None:
            observed = np.concatenate([observed, np.asarray(slopes, dtype=float).T.ravel()])
        self._y = observed
        dimensions = self._x.shape[1]
        bounds = [(np.log(SHORTEST), np.log(LONGEST))] * dimensions
        begin = np.full(dimensions, np.log(TYPICAL))
        fit = minimize(self._unlikely, begin, method="L-BFGS-B", bounds=bounds)
        self.lengths: Floats = np.exp(fit.x)
        self._members, self._shares = self._ensemble(fit.x, bounds)
        self.calibration = max(1.0, float(np.sqrt(np.mean(self.left_out() ** 2))))

    def predict(self, inputs: Floats) -> tuple[Floats, Floats]:
        """Mean and standard deviation at inputs (m, d), each of shape (m,)."""
        every = np.array([self._of(member, inputs) for member in self._members])
        mean = self._shares @ every[:, 0]
        spread = self._shares @ (every[:, 1] + (every[:, 0] - mean) ** 2)
        return self._mean + mean, self.calibration * np.sqrt(spread)

    def left_out(self) -> Floats:
        """Error at each design in deviations, predicted without it and its gradient, shape (n,).

        In closed form (Rasmussen & Williams, equation 5.12, for blocks).
        """
        squares = np.array([self._left_out(member) ** 2 for member in self._members])
        return np.asarray(np.sqrt(self._shares @ squares))

    def draws(self, inputs: Floats, count: int) -> Floats:
        """Functions drawn from what is known of it, at inputs (m, d), shape (count, m)."""
        random = np.random.default_rng(self._seed)
        drawn = []
        for member, times in zip(
            self._members, random.multinomial(count, self._shares), strict=True
        ):
            if not times:
                continue
            cross = self._covariance(inputs, self._x, member.lengths, at_a=False)
            prior = self._covariance(inputs, inputs, member.lengths, at_a=False, at_b=False)
            left = prior - cross @ cho_solve(member.factor, cross.T)
            sizes, directions = np.linalg.eigh((left + left.T) / 2)
            root = directions * np.sqrt(member.variance * np.clip(sizes, 0.0, None))
            normal = random.standard_normal((times, len(inputs)))
            drawn.append(cross @ member.weights + self.calibration * normal @ root.T)
        return self._mean + np.concatenate(drawn)

    # -- members ---------------------------------------------------------------------------------

    def _ensemble(
        self, best: Floats, bounds: list[tuple[float, float]]
    ) -> tuple[list[_Member], Floats]:
        """Members around the likeliest lengths, and their shares."""
        d, steps = len(best), STEP * np.eye(len(best))
        curvature = np.empty((d, d))
        for i in range(d):
            for j in range(i, d):
                corners = (
                    self._unlikely(best + a * steps[i] + b * steps[j]) * a * b
                    for a in (1, -1)
                    for b in (1, -1)
                )
                curvature[i, j] = curvature[j, i] = sum(corners) / (4 * STEP**2)
        sizes, directions = np.linalg.eigh(curvature)
        narrow = np.maximum(sizes, 1 / SPREAD**2)  # never wider than the prior
        sobol = qmc.Sobol(d, rng=self._seed).random(MEMBERS)
        normal = np.asarray(norm.ppf(np.clip(sobol, 1e-3, 1 - 1e-3)), dtype=float)
        drawn = best + normal @ (directions / np.sqrt(narrow)).T
        low, high = np.transpose(bounds)
        members, weights = [], []
        for logarithms, z in zip(np.clip(drawn, low, high), normal, strict=True):
            try:
                members.append(self._member(logarithms))
            except np.linalg.LinAlgError:
                continue
            weights.append(float(z @ z) / 2 - members[-1].unlikely)
        if not members:
            return [self._member(best)], np.ones(1)
        shares = np.exp(np.array(weights) - max(weights))
        return members, shares / shares.sum()

    def _member(self, logarithms: Floats) -> _Member:
        lengths = np.exp(logarithms)
        covariance = self._covariance(self._x, self._x, lengths)
        covariance[np.diag_indices_from(covariance)] *= 1 + NUGGET
        factor = cho_factor(covariance, lower=True)
        weights = cho_solve(factor, self._y)
        count = len(self._y)
        observed = max(float(self._y @ weights), 1e-300)
        spread = float(np.log(np.diag(factor[0])).sum())
        apart = (logarithms - np.log(TYPICAL)) / SPREAD
        unlikely = count * np.log(observed / count) / 2 + spread + float(apart @ apart) / 2
        # a variance that is learnt with the mean and the lengths makes predictions Student's t
        # with as many degrees of freedom fewer; this is the variance of it
        freedom = max(count - 1 - len(lengths) - 2, 1)
        return _Member(lengths, factor, weights, observed / freedom, unlikely)

    def _unlikely(self, logarithms: Floats) -> float:
        try:
            return self._member(logarithms).unlikely
        except np.linalg.LinAlgError:
            return 1e12

    def _of(self, member: _Member, inputs: Floats) -> tuple[Floats, Floats]:
        """Mean, from the observed mean, and variance."""
        cross = self._covariance(inputs, self._x, member.lengths, at_a=False)
        explained = np.einsum("ij,ji->i", cross, cho_solve(member.factor, cross.T))
        return cross @ member.weights, member.variance * np.clip(1 - explained, 0.0, None)

    def _left_out(self, member: _Member) -> Floats:
        inverse = cho_solve(member.factor, np.eye(len(self._y)))
        residuals = []
        for i in range(len(self._x)):
            block = np.arange(i, len(self._y), len(self._x))
            spread = np.linalg.inv(inverse[np.ix_(block, block)])
            off = float(spread[0] @ member.weights[block])
            residuals.append(off / np.sqrt(member.variance * spread[0, 0]))
        return np.array(residuals)

    def _covariance(
        self, a: Floats, b: Floats, lengths: Floats, *, at_a: bool = True, at_b: bool = True
    ) -> Floats:
        """Covariance of values, then slopes where they count, at a and b, for a variance of 1."""
        apart = (a[:, None] - b[None]) / lengths
        reach = np.sqrt(5 * np.einsum("ijk,ijk->ij", apart, apart))
        fall = np.exp(-reach)
        value = (1 + reach + reach**2 / 3) * fall
        if not self._with_slopes or not (at_a or at_b):
            return np.asarray(value)
        # with s = |apart|², first = −2 dk/ds and second = 4 d²k/ds²
        first, second = 5 / 3 * (1 + reach) * fall, 25 / 3 * fall
        scaled = apart / lengths
        rows, columns = range(len(lengths) * at_a), range(len(lengths) * at_b)
        blocks = [[value, *(first * scaled[:, :, j] for j in columns)]]
        for i in rows:
            row = [-first * scaled[:, :, i]]
            for j in columns:
                diagonal = first / lengths[i] ** 2 if i == j else 0.0
                row.append(diagonal - second * scaled[:, :, i] * scaled[:, :, j])
            blocks.append(row)
        return np.block(blocks)
