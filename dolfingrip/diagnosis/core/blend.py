"""Readings between simulations: a blend of the tangents at those that were made.

    Δ(u) = Φ g(u),    g(u) = Σ wᵢ (gᵢ + Jᵢ (u − uᵢ)),    wᵢ ∝ |u − uᵢ|⁻⁴

It goes through all values and slopes that were simulated (Shepard's interpolation of Taylor
polynomials: Farwig, Math. Comp. 46, 1986). u are coordinates in which readings are nearly straight:
:meth:`~dolfingrip.diagnosis.core.unknown.Unknown.coordinate`. Φ are right singular vectors of what
was simulated, by the noise. A blend that corrects others fades away from its simulations: zero has
the weight ℓ⁻⁴ in the sum then. Of one that does not fade, a coordinate that all simulations share
is left out of the distances.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from scipy.stats import qmc

from dolfingrip.diagnosis.core.unknown import Unknown, coordinates
from dolfingrip.diagnosis.policy import Policy

POWER: Final = 2
"""Of the squared distance, by which weights fall."""


@dataclass(frozen=True, eq=False)
class Tangents:
    """Simulated readings, or changes of readings, with their derivatives.

    Attributes:
        u: coordinates of each simulation, shape (m, d).
        told: values and derivatives by u, shape (m, n, 1 + d).
    """

    u: np.ndarray
    told: np.ndarray

    @classmethod
    def stacked(cls, every: Sequence[Tangents]) -> Tangents:
        """Put several of the same numbers one below the other.

        Args:
            every: one or more.
        """
        return cls(np.vstack([e.u for e in every]), np.concatenate([e.told for e in every]))

    def beside(self, by: np.ndarray, start: np.ndarray) -> Tangents:
        """Put readings that are linear in the coordinates below the others.

        Args:
            by: derivatives by u, shape (k, d).
            start: coordinates where they are 0, shape (d,).
        """
        slopes = np.broadcast_to(by, (len(self.u), *by.shape))
        linear = np.dstack([slopes @ (self.u - start)[..., None], slopes])
        return replace(self, told=np.hstack([self.told, linear]))

    def rows(self, kept: np.ndarray) -> Tangents:
        """Restrict them to some of the readings."""
        return replace(self, told=self.told[:, kept])


@dataclass(frozen=True, eq=False)
class TangentBlend:
    """A function of some unknowns that goes through simulated tangents.

    Attributes:
        numbers: the unknowns, d of them.
        bent: ln's standard deviation, and mean by spread, of those whose coordinate is not ζ; else
            0, shape (2, d).
        columns: Φ, shape (n, k), in the units of the readings.
        u: coordinates of the simulations, shape (m, d).
        values, slopes: g there, shape (m, k), and its derivatives by u, shape (m, k, d).
        fading: ℓ⁻⁴; 0 where it does not fade.
    """

    numbers: Sequence[Unknown]
    bent: np.ndarray
    columns: np.ndarray
    u: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    fading: float

    @classmethod
    def of(
        cls,
        numbers: Sequence[Unknown],
        runs: Tangents,
        noise: np.ndarray,
        length: float = np.inf,
        missed: float = Policy().matters,
    ) -> TangentBlend:
        """Blend simulations.

        Args:
            numbers: that they are functions of.
            runs: the simulations.
            noise: of the readings, by which components count, shape (n,).
            length: ℓ, in standard deviations of the numbers.
            missed: of a reading, which components may leave, by its noise.
        """
        rows = np.moveaxis(runs.told, 2, 1) / noise  # (m, 1 + d, n)
        ways = components(rows.reshape(-1, len(noise)), missed)
        inner = rows @ ways.T
        bent = [number.bend for number in numbers]
        return cls(
            numbers, np.array(bent).reshape(-1, 2).T, ways.T * noise[:, None], runs.u, inner[:, 0],
            np.moveaxis(inner[:, 1:], 1, 2), np.square(length) ** -float(POWER),
        )  # fmt: skip

    @cached_property
    def _tells(self) -> np.ndarray:
        """Which coordinates tell the nearest simulation, (d,): not those that all of them share."""
        return (np.ptp(self.u, axis=0) > 1e-6) | (self.fading > 0)

    def at(self, zeta: np.ndarray) -> np.ndarray:
        """g at many places, shape (places, k).

        Args:
            zeta: shape (places, d).
        """
        return self.with_slopes(zeta)[0]

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """g at many places, shape (places, k), and its derivatives by ζ, shape (places, k, d).

        Args:
            zeta: shape (places, d).
        """
        u, rate = coordinates(zeta, *self.bent)
        value, slopes = self.at_coordinates(u)
        return value, slopes * rate[:, None]

    def at_coordinates(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """g at many places, shape (places, k), and its derivatives by u, shape (places, k, d).

        Args:
            u: shape (places, d).
        """
        off = u[:, None] - self.u
        apart = off * self._tells
        square = np.square(apart).sum(axis=2) + 1e-9
        weight = 1 / square**POWER
        weight /= weight.sum(axis=1, keepdims=True) + self.fading
        m, k, d = self.slopes.shape
        steps = np.matmul(off.swapaxes(0, 1), self.slopes.swapaxes(1, 2)).swapaxes(0, 1)
        linear = self.values + steps  # (places, m, k)
        g = (weight[:, None] @ linear)[:, 0]
        slopes = (weight @ self.slopes.reshape(m, k * d)).reshape(-1, k, d)
        pull = (linear - g[:, None]) * (-2 * POWER * weight / square)[..., None]
        return g, slopes + pull.swapaxes(1, 2) @ apart

    def rows(self, kept: np.ndarray) -> TangentBlend:
        """Restrict it to some of the readings."""
        return replace(self, columns=self.columns[kept])


def components(rows: np.ndarray, missed: float) -> np.ndarray:
    """The components without which no row would miss more than it may, shape (k, n).

    Args:
        rows: values and derivatives by the noise, shape (rows, n).
        missed: root mean square that a row may miss.
    """
    _, sizes, right = np.linalg.svd(rows, full_matrices=False)
    left = np.sqrt(np.cumsum((sizes**2)[::-1])[::-1])
    k = int((left > missed * np.sqrt(rows.shape[1])).sum())
    return np.asarray(right[: max(k, 1)])


def places(box: np.ndarray, count: int) -> np.ndarray:
    """Places that are evenly spread (Sobol's sequence), shape (count, d).

    Args:
        box: ranges of ζ, shape (d, 2).
        count: how many.
    """
    sobol = qmc.Sobol(len(box), scramble=True, rng=np.random.default_rng(len(box)))
    exponent = max(int(np.ceil(np.log2(count))), 1)
    unit = sobol.random_base2(exponent)[:count]
    edges = (1 + 2 * 0.01) * (unit - 0.5) + 0.5
    return np.asarray(box[:, 0] + np.clip(edges, 0, 1) * (box[:, 1] - box[:, 0]))
