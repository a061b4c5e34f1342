"""Emulators: changes of all readings by a cause, as functions of its numbers.

    Δ(ζ) = Φ g(ζ)

Polynomials (:mod:`dolfingrip.diagnosis.core.polynomial`) may be corrected where exact simulations
are known, may be added to one another, and may have readings that are proportional to a factor of
all moduli.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from dolfingrip.diagnosis.core.unknown import Factor


@dataclass(frozen=True, eq=False)
class Emulator(ABC):
    """Changes of n readings by d numbers.

    Attributes:
        columns: Φ, shape (n, k), in the units of the readings.
        errors: columns of the error, one standard deviation each, shape (n, l).
    """

    columns: np.ndarray
    errors: np.ndarray

    @abstractmethod
    def at(self, zeta: np.ndarray) -> np.ndarray:
        """g at many places, shape (places, k).

        Args:
            zeta: shape (places, d).
        """

    @abstractmethod
    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """g, shape (k,), and its derivatives, shape (k, d), at one place, shape (d,)."""

    def rows(self, kept: np.ndarray) -> Self:
        """Restrict the emulator to some of the readings."""
        return replace(self, columns=self.columns[kept], errors=self.errors[kept])


@dataclass(frozen=True, eq=False)
class Local(Emulator):
    """A correction of other emulators by exact simulations and their derivatives.

    The mean of a Gaussian process of covariance exp(−½ |ζ − ζ′|²/ℓ²) whose values and slopes are
    known at some places (Rasmussen & Williams, Gaussian Processes for Machine Learning, 2006,
    section 9.4).

    Attributes:
        places: shape (m, d).
        exact: simulated readings and derivatives there, shape (m, n, 1 + d).
        length: ℓ.
    """

    places: np.ndarray
    exact: np.ndarray
    length: float

    @classmethod
    def of(
        cls, places: np.ndarray, exact: np.ndarray, emulated: np.ndarray, length: float
    ) -> Local:
        """Through what is exact at all places, by what other emulators tell there."""
        told = exact - emulated
        every = [_related(place, places, length) for place in places]
        inner = np.vstack([np.vstack([value, slopes.T]) for value, slopes in every])
        scale = np.sqrt(np.diag(inner))
        # places that are close tell nearly the same
        inner = inner / np.outer(scale, scale) + 1e-10 * np.eye(len(inner))
        data = np.moveaxis(told, 1, 2).reshape(len(inner), -1) / scale[:, None]
        columns = np.linalg.solve(inner, data).T / scale
        return cls(columns, np.zeros((len(columns), 0)), places, exact, length)

    def at(self, zeta: np.ndarray) -> np.ndarray:
        return np.array([_related(each, self.places, self.length)[0] for each in zeta])

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return _related(zeta, self.places, self.length)

    def rows(self, kept: np.ndarray) -> Self:
        return replace(super().rows(kept), exact=self.exact[:, kept])


def _related(zeta: np.ndarray, places: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Covariances with the value and the slopes at each place, (m (1 + d),), and their slopes."""
    away = (zeta - places) / length
    near = np.exp(-0.5 * (away**2).sum(axis=1))[:, None]
    value = np.hstack([near, near * away / length])
    first = -near * away / length
    second = (
        near[:, :, None] * (np.eye(len(zeta)) - away[:, :, None] * away[:, None, :]) / length**2
    )
    slopes = np.concatenate([first[:, None], second], axis=1)
    return value.ravel(), slopes.reshape(-1, len(zeta))


@dataclass(frozen=True, eq=False)
class Stacked(Emulator):
    """Several emulators of the same numbers, whose changes add.

    Attributes:
        parts: of which ``columns`` and ``errors`` stand side by side.
    """

    parts: tuple[Emulator, ...]

    @classmethod
    def of(cls, *parts: Emulator) -> Stacked:
        """Stack emulators."""
        errors = np.hstack([each.errors for each in parts])
        return cls(np.hstack([each.columns for each in parts]), errors, parts)

    def at(self, zeta: np.ndarray) -> np.ndarray:
        return np.hstack([each.at(zeta) for each in self.parts])

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values, slopes = zip(*(each.with_slopes(zeta) for each in self.parts), strict=True)
        return np.concatenate(values), np.vstack(slopes)

    def rows(self, kept: np.ndarray) -> Self:
        return replace(super().rows(kept), parts=tuple(each.rows(kept) for each in self.parts))


@dataclass(frozen=True, eq=False)
class Scaled(Emulator):
    """An emulator some of whose readings are c times what they are at c = 1.

    Attributes:
        inner: of a cause's change at c = 1; None for what c alone changes.
        factor: c by ζ, the first of the model's own numbers.
    """

    inner: Emulator | None
    factor: Factor

    @classmethod
    def of(cls, inner: Emulator, scaled: np.ndarray, factor: Factor) -> Scaled:
        """Scale an emulator of a cause, whose readings are ``scaled`` or not, (n,)."""
        on = scaled[:, None]
        columns = np.hstack([inner.columns * on, inner.columns * ~on])
        return cls(columns, inner.errors, inner, factor)

    @classmethod
    def alone(cls, base: np.ndarray, scaled: np.ndarray, factor: Factor) -> Scaled:
        """Make the emulator of what c changes about the model's readings (n,)."""
        return cls((base * scaled)[:, None], np.zeros((len(base), 0)), None, factor)

    def at(self, zeta: np.ndarray) -> np.ndarray:
        c = self.factor(zeta[:, :1])
        if self.inner is None:
            return c - 1
        g = self.inner.at(zeta[:, 1:])
        return np.hstack([c * g, g])

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        c = float(self.factor(zeta[0]))
        rate = self.factor.std * c
        if self.inner is None:
            return np.array([c - 1]), np.array([[rate]])
        g, slopes = self.inner.with_slopes(zeta[1:])
        on = np.column_stack([rate * g, c * slopes])
        return np.r_[c * g, g], np.vstack([on, np.column_stack([0 * g, slopes])])
