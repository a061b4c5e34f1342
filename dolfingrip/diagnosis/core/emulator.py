"""What a cause changes about all readings, as a polynomial of its numbers.

    Δ(ζ) = Φ g(ζ)

Φ are right singular vectors of simulated changes, scaled by the noise, and g polynomials that are
fitted by least squares (principal-component emulation: Higdon et al., J. Am. Stat. Assoc. 103,
2008). The error of what was left out of the fit stands beside them as columns of one standard
deviation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import numpy as np
from scipy.stats import qmc

from dolfingrip.diagnosis.policy import POLICY

EVERY = 5
"""One simulation in so many is left out of the fit, and tells its error."""


@dataclass(frozen=True, eq=False)
class Emulator:
    """Changes of n readings by d numbers.

    Attributes:
        columns: Φ, shape (n, k), in the units of the readings.
        exponents: of the monomials, shape (m, d).
        weights: of the monomials in each component, shape (m, k).
        errors: columns of the error, one standard deviation each, shape (n, l).
        left: root mean square error of a simulation that was left out, by the noise.
        middle, half: of the range that it was trained in, shape (d,); monomials are of
            (ζ − middle)/half.
        takes: which of the model's own numbers come before those of the cause in ζ.
    """

    columns: np.ndarray
    exponents: np.ndarray
    weights: np.ndarray
    errors: np.ndarray
    left: float
    middle: np.ndarray
    half: np.ndarray
    takes: tuple[int, ...] = ()

    def at(self, zeta: np.ndarray) -> np.ndarray:
        """g at many places, shape (places, k).

        Args:
            zeta: shape (places, d).
        """
        return np.asarray(
            _monomials((zeta - self.middle) / self.half, self.exponents) @ self.weights
        )

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """g, shape (k,), and its derivatives, shape (k, d), at one place, shape (d,)."""
        value, slopes = monomials_with_slopes((zeta - self.middle) / self.half, self.exponents)
        return value @ self.weights, self.weights.T @ (slopes / self.half)

    def rows(self, kept: np.ndarray) -> Emulator:
        """Of some of the readings."""
        return replace(self, columns=self.columns[kept], errors=self.errors[kept])


@dataclass(frozen=True, eq=False)
class Stacked(Emulator):
    """Several emulators of the same numbers, whose changes add.

    Attributes:
        parts: of which ``columns`` and ``errors`` stand side by side.
    """

    parts: tuple[Emulator, ...] = ()

    @classmethod
    def of(cls, parts: tuple[Emulator, ...]) -> Stacked:
        """All parts take the same numbers."""
        first = parts[0]
        return cls(
            np.hstack([each.columns for each in parts]), first.exponents, first.weights,
            np.hstack([each.errors for each in parts]),
            float(np.sqrt(sum(each.left**2 for each in parts))), first.middle, first.half,
            first.takes, parts,
        )  # fmt: skip

    def at(self, zeta: np.ndarray) -> np.ndarray:
        return np.hstack([each.at(zeta) for each in self.parts])

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = [each.with_slopes(zeta) for each in self.parts]
        return np.concatenate([g for g, _ in found]), np.vstack([slopes for _, slopes in found])

    def rows(self, kept: np.ndarray) -> Stacked:
        return replace(
            self, columns=self.columns[kept], errors=self.errors[kept],
            parts=tuple(each.rows(kept) for each in self.parts),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Mended(Emulator):
    """An emulator with what one exact simulation, and its derivatives, told beyond it.

    The rest is a Gaussian process of ζ whose value and slopes are known at one place:
    (d + D (ζ − ζ*)) exp(−½ |ζ − ζ*|²/ℓ²) (Rasmussen & Williams, Gaussian Processes for Machine
    Learning, 2006, section 9.4).

    Attributes:
        inner: the emulator.
        inside: which of ζ it takes, shape (d₀,).
        at_place: ζ*, shape (d,).
        length: ℓ.
    """

    inner: Emulator | None = None
    inside: np.ndarray | None = None
    at_place: np.ndarray | None = None
    length: float = 1.0

    @classmethod
    def of(
        cls, inner: Emulator, inside: np.ndarray, takes: tuple[int, ...], place: np.ndarray,
        missed: np.ndarray, length: float, surer: float,
    ) -> Mended:  # fmt: skip
        """Mend an emulator.

        Args:
            inner: the emulator.
            inside: which of ζ it takes.
            takes: of the model's own numbers.
            place: ζ*, shape (d,).
            missed: exact less emulated readings and their derivatives, shape (n, 1 + d).
            length: ℓ.
            surer: error by that before.
        """
        return cls(
            np.hstack([inner.columns, missed]), inner.exponents, inner.weights,
            surer * inner.errors, inner.left, inner.middle, inner.half, takes, inner, inside,
            place, length,
        )  # fmt: skip

    def at(self, zeta: np.ndarray) -> np.ndarray:
        assert self.inner is not None
        away = zeta - self.at_place
        near = np.exp(-0.5 * (away**2).sum(axis=1, keepdims=True) / self.length**2)
        return np.hstack([self.inner.at(zeta[:, self.inside]), near, near * away])

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        assert self.inner is not None
        value, own = self.inner.with_slopes(zeta[self.inside])
        slopes = np.zeros((len(value), len(zeta)))
        slopes[:, self.inside] = own
        away = zeta - self.at_place
        near = float(np.exp(-0.5 * away @ away / self.length**2))
        fading = -near * away / self.length**2
        local = np.vstack([fading, near * np.eye(len(zeta)) + np.outer(away, fading)])
        return np.concatenate([value, [near], near * away]), np.vstack([slopes, local])

    def rows(self, kept: np.ndarray) -> Mended:
        assert self.inner is not None
        return replace(
            self, columns=self.columns[kept], errors=self.errors[kept],
            inner=self.inner.rows(kept),
        )  # fmt: skip


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
    left_out = np.arange(count) % EVERY == EVERY - 1
    white = changes / scale
    _, values, right = np.linalg.svd(white, full_matrices=False)
    variance = np.cumsum((values**2)[::-1])[::-1] / (count * white.shape[1])
    k = int(np.clip((variance > POLICY.component_error**2).sum(), 1, POLICY.components))
    basis = right[:k]
    exponents = _exponents(d, POLICY.degrees[min(d, len(POLICY.degrees)) - 1], count)
    told = _monomials((zeta - middle) / half, exponents)
    score = white @ basis.T
    weights, *_ = np.linalg.lstsq(told[~left_out], score[~left_out], rcond=1e-10)
    rest = white[left_out] - told[left_out] @ weights @ basis
    weights, *_ = np.linalg.lstsq(told, score, rcond=1e-10)
    # places count as the prior has them: what is far out hardly matters
    near = np.clip(0.0, *box.T)
    weight = np.exp(-0.25 * ((zeta[left_out] - near) ** 2).sum(axis=1))
    weight /= max(weight.sum(), 1e-300)
    rest = rest * np.sqrt(weight)[:, None]
    _, sizes, ways = np.linalg.svd(rest, full_matrices=False)
    kept = slice(0, POLICY.error_columns)
    errors = (sizes[kept, None] * ways[kept]).T * scale[:, None]
    left = float(np.sqrt((rest**2).sum() / rest.shape[1]))
    return Emulator(basis.T * scale[:, None], exponents, weights, errors, left, middle, half)


def linear(change: np.ndarray) -> Emulator:
    """Of one number, whose change by one standard deviation is told, shape (n,)."""
    none = np.zeros((len(change), 0))
    return Emulator(
        change[:, None], np.array([[1]]), np.ones((1, 1)), none, 0.0, np.zeros(1), np.ones(1)
    )


def _exponents(d: int, degree: int, count: int) -> np.ndarray:
    """All monomials up to a degree, or to that which half of the simulations can tell."""
    while True:
        rows = [
            np.bincount(np.array(chosen, dtype=int), minlength=d)
            for total in range(degree + 1)
            for chosen in combinations_with_replacement(range(d), total)
        ]
        if len(rows) <= count / 2 or degree == 1:
            return np.array(rows, dtype=int).reshape(len(rows), d)
        degree -= 1


def _monomials(scaled: np.ndarray, exponents: np.ndarray) -> np.ndarray:
    powers = scaled[:, :, None] ** np.arange(exponents.max() + 1)
    found = np.ones((len(scaled), len(exponents)))
    for i in range(scaled.shape[1]):
        found *= powers[:, i][:, exponents[:, i]]
    return found


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
