"""Emulators: changes of all readings by a cause, as polynomials of its numbers.

    Δ(ζ) = Φ g(ζ)

Φ are right singular vectors of simulated changes, scaled by the noise, and g polynomials that are
fitted by least squares (principal-component emulation: Higdon et al., J. Am. Stat. Assoc. 103,
2008). The error of what was left out of the fit stands beside them as columns of one standard
deviation.

Readings may also be proportional to a factor of all moduli.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from itertools import combinations_with_replacement
from typing import Self

import numpy as np
from scipy.stats import qmc

from dolfingrip.diagnosis.core.unknown import Factor
from dolfingrip.diagnosis.policy import POLICY


@dataclass(frozen=True, eq=False)
class Emulator(ABC):
    """Changes of n readings by d numbers.

    Attributes:
        columns: Φ, shape (n, k), in the units of the readings.
        errors: columns of the error, one standard deviation each, shape (n, l).
        left: root mean square error of a simulation that was left out, by the noise.
        takes: which of the model's own numbers come before those of the cause in ζ.
    """

    columns: np.ndarray
    errors: np.ndarray
    left: float
    takes: tuple[int, ...] = field(default=(), kw_only=True)

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
class PolynomialEmulator(Emulator):
    """A polynomial of ζ itself.

    Attributes:
        exponents: of the monomials, shape (m, d).
        weights: of the monomials in each component, shape (m, k).
        middle, half: of the range that it was trained in, shape (d,); monomials are of
            (ζ − middle)/half.
    """

    exponents: np.ndarray
    weights: np.ndarray
    middle: np.ndarray
    half: np.ndarray

    def at(self, zeta: np.ndarray) -> np.ndarray:
        u = (zeta - self.middle) / self.half
        return np.asarray(monomials(u, self.exponents) @ self.weights)

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        value, slopes = monomials_with_slopes((zeta - self.middle) / self.half, self.exponents)
        return value @ self.weights, self.weights.T @ (slopes / self.half)


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
        return cls(columns, np.zeros((len(columns), 0)), 0.0, places, exact, length)

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
        """Stack emulators that take the same nuisances."""
        return cls(
            np.hstack([each.columns for each in parts]),
            np.hstack([each.errors for each in parts]),
            float(np.sqrt(sum(each.left**2 for each in parts))), parts, takes=parts[0].takes,
        )  # fmt: skip

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
    takes: tuple[int, ...] = field(default=(0,), kw_only=True)

    @classmethod
    def of(cls, inner: Emulator, scaled: np.ndarray, factor: Factor) -> Scaled:
        """Scale an emulator of a cause, whose readings are ``scaled`` or not, (n,)."""
        on = scaled[:, None]
        columns = np.hstack([inner.columns * on, inner.columns * ~on])
        return cls(columns, inner.errors, inner.left, inner, factor)

    @classmethod
    def alone(cls, base: np.ndarray, scaled: np.ndarray, factor: Factor) -> Scaled:
        """Make the emulator of what c changes about the model's readings (n,)."""
        return cls((base * scaled)[:, None], np.zeros((len(base), 0)), 0.0, None, factor)

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


def places(box: np.ndarray, count: int) -> np.ndarray:
    """Places of training, evenly spread, shape (count, d).

    Args:
        box: ranges of ζ, shape (d, 2).
        count: how many.
    """
    sobol = qmc.Sobol(len(box), scramble=True, rng=np.random.default_rng(len(box)))
    exponent = max(int(np.ceil(np.log2(count))), 1)
    unit = sobol.random_base2(exponent)[:count]
    edges = (1 + 0.02) * (unit - 0.5) + 0.5
    return np.asarray(box[:, 0] + np.clip(edges, 0, 1) * (box[:, 1] - box[:, 0]))


def trained(
    zeta: np.ndarray, changes: np.ndarray, scale: np.ndarray, box: np.ndarray | None = None
) -> Emulator:
    """An emulator from simulated changes.

    Args:
        zeta: shape (places, d).
        changes: shape (places, n).
        scale: noise of the readings, shape (n,).
        box: ranges of ζ, shape (d, 2); the reach of every number where None.
    """
    count, d = zeta.shape
    if box is None:
        box = np.tile([-POLICY.reach, POLICY.reach], (d, 1))
    middle, half = box.mean(axis=1), np.maximum(np.ptp(box, axis=1) / 2, 1e-6)
    left_out = np.arange(count) % POLICY.left_out == POLICY.left_out - 1
    white = changes / scale
    basis = principal(white, POLICY.components)
    degree = POLICY.degrees[min(d, len(POLICY.degrees)) - 1]
    exponents = exponents_up_to(degree, d)
    while len(exponents) > count / 2 and degree > 1:  # which half of the simulations can tell
        degree -= 1
        exponents = exponents_up_to(degree, d)
    basis_values = monomials((zeta - middle) / half, exponents)
    score = white @ basis.T
    weights, *_ = np.linalg.lstsq(basis_values[~left_out], score[~left_out], rcond=1e-10)
    rest = white[left_out] - basis_values[left_out] @ weights @ basis
    weights, *_ = np.linalg.lstsq(basis_values, score, rcond=1e-10)
    errors, left = error_of(rest, zeta[left_out] - np.clip(0.0, *box.T), scale)
    return PolynomialEmulator(
        basis.T * scale[:, None], errors, left, exponents, weights, middle, half
    )


def linear(change: np.ndarray) -> Emulator:
    """Make an emulator of one number from its change by one standard deviation, shape (n,)."""
    none = np.zeros((len(change), 0))
    first = np.array([[1]])
    return PolynomialEmulator(
        change[:, None], none, 0.0, first, np.ones((1, 1)), np.zeros(1), np.ones(1)
    )


def exponents_up_to(degree: int, d: int) -> np.ndarray:
    """Return the exponents of all monomials of d numbers up to a degree, shape (m, d)."""
    rows = [
        np.bincount(np.array(chosen, dtype=int), minlength=d)
        for total in range(degree + 1)
        for chosen in combinations_with_replacement(range(d), total)
    ]
    return np.array(rows, dtype=int).reshape(len(rows), d)


def monomials(u: np.ndarray, exponents: np.ndarray) -> np.ndarray:
    """(places, m) of u, shape (places, d)."""
    powers = u[:, :, None] ** np.arange(exponents.max(initial=0) + 1)
    found = np.ones((len(u), len(exponents)))
    for i in range(u.shape[1]):
        found *= powers[:, i][:, exponents[:, i]]
    return found


def principal(white: np.ndarray, most: int) -> np.ndarray:
    """The components without which rows would miss more than they may, shape (k, n).

    Args:
        white: changes by the noise, shape (rows, n).
        most: of them.
    """
    _, sizes, right = np.linalg.svd(white, full_matrices=False)
    variance = np.cumsum((sizes**2)[::-1])[::-1] / white.size
    k = int(np.clip((variance > POLICY.component_error**2).sum(), 1, most))
    return np.asarray(right[:k])


def error_of(rest: np.ndarray, off: np.ndarray, scale: np.ndarray) -> tuple[np.ndarray, float]:
    """Columns of the error, shape (n, l), and its root mean square by the noise.

    Args:
        rest: what places left, by the noise, shape (places, n).
        off: how far these are from the middle, shape (places, d): they count as the prior has them,
            what is far out hardly matters.
        scale: noise of the readings, shape (n,).
    """
    weight = np.exp(-0.25 * (off**2).sum(axis=1))
    rest = rest * np.sqrt(weight / max(weight.sum(), 1e-300))[:, None]
    _, sizes, ways = np.linalg.svd(rest, full_matrices=False)
    kept = slice(0, POLICY.error_columns)
    errors = (sizes[kept, None] * ways[kept]).T * scale[:, None]
    return errors, float(np.sqrt((rest**2).sum() / rest.shape[1]))


def monomials_with_slopes(u: np.ndarray, exponents: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Monomials, shape (m,), and their derivatives, shape (m, d), at one place u, shape (d,)."""
    d = len(u)
    if not d:
        return np.ones(len(exponents)), np.zeros((len(exponents), 0))
    orders = np.arange(exponents.max() + 1)
    powers = u[:, None] ** orders
    down = np.zeros_like(powers)
    down[:, 1:] = powers[:, :-1] * orders[1:]
    rows = np.arange(d)
    each, changed = powers[rows, exponents], down[rows, exponents]
    before, after = np.ones_like(each), np.ones_like(each)
    for i in range(1, d):
        before[:, i] = before[:, i - 1] * each[:, i - 1]
        after[:, d - 1 - i] = after[:, d - i] * each[:, d - i]
    return before[:, -1] * each[:, -1], before * changed * after
