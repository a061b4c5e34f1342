"""Evidence of two effects together: a normal prior of both strengths, in closed form.

With whitened changes W = [w_e, w_f], prior means m and S = diag(s²), and A = WᵀW + S⁻¹,
b = Wᵀr + S⁻¹m: ln BF = −½ ln |1 + S WᵀW| + ½ bᵀA⁻¹b − ½ mᵀS⁻¹m. Strengths that can only be positive
cut the prior, which multiplies by P(a > 0) of the posterior N(A⁻¹b, A⁻¹) and divides by that of
the prior.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import log_ndtr, logsumexp

from benchmarks.blind.exact.orthant import log_both_positive
from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.screen import Screen

NEGLIGIBLE = 12.0
"""Pairs of shapes whose ln BF is this much below the largest keep an upper bound of it."""


@dataclass(frozen=True, eq=False)
class PairScores:
    """Evidence of each pair of candidates.

    Attributes:
        members: numbers of the two candidates, shape (pairs, 2).
        log_evidence: ln BF against no effect, shape (pairs,).
        strength_sigma: lengths of both fitted changes at the pair's best shapes, (pairs, 2).
    """

    members: npt.NDArray[np.intp]
    log_evidence: Vector
    strength_sigma: Matrix


class Pairs:
    """All pairs of visible candidates of a screen, prepared once."""

    def __init__(self, screen: Screen) -> None:
        self._screen = screen
        visible = [int(i) for i in np.flatnonzero(screen.visible)]
        self.members = np.array(list(itertools.combinations(visible, 2)), dtype=int).reshape(-1, 2)
        combinations = [
            (k, a, b)
            for k, (e, f) in enumerate(self.members)
            for a in np.flatnonzero(screen.owner == e)
            for b in np.flatnonzero(screen.owner == f)
        ]
        table = np.array(combinations, dtype=int).reshape(-1, 3)
        self._pair, self._shapes = table[:, 0], table[:, 1:]
        self._count = np.bincount(self._pair, minlength=len(self.members))
        gram = (screen.columns.T @ screen.columns)[
            self._shapes[:, :, None], self._shapes[:, None, :]
        ]
        m, s = screen.mean[self._shapes], screen.spread[self._shapes]
        self._sided = screen.one_sided[self._shapes]
        self._posterior = np.linalg.inv(gram + _diagonal(1 / s**2))
        self._std = np.sqrt(np.einsum("kii->ki", self._posterior))
        self._prior_pull = m / s**2
        scaled = s[:, :, None] * gram * s[:, None, :] + np.eye(2)
        self._constant = -0.5 * np.linalg.slogdet(scaled)[1] - 0.5 * np.sum((m / s) ** 2, axis=1)
        self._constant -= np.where(self._sided, log_ndtr(m / s), 0.0).sum(axis=1)

    def scores(self, whitened: Vector) -> PairScores:
        """Evidence of each pair for a whitened residual of shape (n,)."""
        if not len(self.members):
            return PairScores(self.members, np.zeros(0), np.zeros((0, 2)))
        logs, mean = self._combinations(whitened)
        total = np.full(len(self.members), -np.inf)
        np.logaddexp.at(total, self._pair, logs)
        order = np.lexsort((logs, self._pair))
        last = order[np.cumsum(self._count) - 1]  # the best combination of each pair
        strength = np.abs(mean[last]) * self._screen.length[self._shapes[last]]
        return PairScores(self.members, total - np.log(self._count), strength)

    def log_sum_bound(self, whitened: Vector) -> float:
        """An upper bound of ln Σ BF over all pairs, at a fraction of the cost of :meth:`scores`."""
        if not len(self.members):
            return -np.inf
        bound, _, _ = self._bounds(whitened)
        return float(logsumexp(bound - np.log(self._count)[self._pair]))

    def _combinations(self, whitened: Vector) -> tuple[Vector, Matrix]:
        """ln BF and expected strengths of each combination of shapes."""
        result, logs, mean = self._bounds(whitened)
        both = self._sided.all(axis=1) & (result > result.max() - NEGLIGIBLE)
        if both.any():
            result[both] = logs[both] + log_both_positive(mean[both], self._posterior[both])
        return result, mean

    def _bounds(self, whitened: Vector) -> tuple[Vector, Vector, Matrix]:
        """An upper bound of ln BF of each combination; ln BF where strengths may have both signs,
        and expected strengths."""
        pulled = (self._screen.columns.T @ whitened)[self._shapes] + self._prior_pull
        mean = np.einsum("kij,kj->ki", self._posterior, pulled)
        logs = self._constant + 0.5 * np.sum(pulled * mean, axis=1)
        # P(both > 0) is below either, which is exact where one strength may have both signs
        cut = np.where(self._sided, log_ndtr(mean / self._std), 0.0)
        return logs + cut.min(axis=1), logs, mean


def _diagonal(entries: Matrix) -> npt.NDArray[np.float64]:
    return np.asarray(entries[:, :, None] * np.eye(entries.shape[1]))
