"""Emulators: changes of all readings by a cause, as functions of its numbers.

    Δ(ζ) = Φ g(ζ)

They are polynomials of coordinates of ζ, from few or many simulations, with known slopes or not, or
cubic pieces between places of one number. They may be corrected where exact simulations are known,
may be added to one another, and may have readings that are proportional to a factor of all moduli.

    Δ(ζ_m, ζ) = Φ Σ_j w_j(ζ_m) P_j(u(ζ))

Φ are right singular vectors of simulated changes, scaled by the noise (principal-component
emulation: Higdon et al., J. Am. Stat. Assoc. 103, 2008). u are coordinates in which a change is
nearly straight: an amplitude by its ordinary value and by a compliance; a shape's own ζ; ζ itself
where simulations cost nothing. Every monomial P_j has at least one amplitude if there is one, so
that a cause of no strength changes nothing. The weights are splines of the moduli where these scale
a simulation exactly, else the moduli are one more coordinate of the polynomial. Values and
derivatives are fitted together by least squares. The error of what was left out of the fit stands
beside them as columns of one standard deviation.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement
from typing import Final, Self

import numpy as np
from scipy.interpolate import BPoly, CubicSpline
from scipy.stats import qmc

from dolfingrip.diagnosis.core.unknown import Unknown
from dolfingrip.diagnosis.policy import POLICY


@dataclass(frozen=True, eq=False)
class Emulator(ABC):
    """Changes of n readings by d numbers.

    Attributes:
        columns: Φ, shape (n, k), in the units of the readings.
        errors: columns of the error, one standard deviation each, shape (n, l).
        ordinary: length of g beside which the errors are of that size. A change that vanishes with
            an amplitude is known the better, the smaller it is; 0 where it is as uncertain
            anywhere.
    """

    columns: np.ndarray
    errors: np.ndarray
    ordinary: float

    def at(self, zeta: np.ndarray) -> np.ndarray:
        """g at many places, shape (places, k).

        Args:
            zeta: shape (places, d).
        """
        return self.with_slopes(zeta)[0]

    @abstractmethod
    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """g at many places, shape (places, k), and its derivatives, shape (places, k, d).

        Args:
            zeta: shape (places, d).
        """

    def uncertainty(self, g: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Factor of the errors at many places, and its derivatives, (places,) and (places, d).

        Args:
            g: shape (places, k).
            slopes: derivatives of g, shape (places, k, d).
        """
        if not self.ordinary:
            return np.ones(len(g)), np.zeros((len(g), slopes.shape[2]))
        square = (g**2).sum(axis=1) / self.ordinary**2
        factor = np.sqrt(2 * square / (1 + square))
        rate = 2 / (np.maximum(factor, 1e-9) * ((1 + square) * self.ordinary) ** 2)
        return factor, rate[:, None] * np.einsum("pk,pkd->pd", g, slopes)

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
        value, slopes = _related(places, places, length)
        both = np.concatenate([value[:, None], slopes.transpose(0, 2, 1)], axis=1)
        inner = both.reshape(-1, value.shape[1])
        scale = np.sqrt(np.diag(inner))
        # places that are close tell nearly the same
        inner = inner / np.outer(scale, scale) + 1e-10 * np.eye(len(inner))
        data = np.moveaxis(told, 1, 2).reshape(len(inner), -1) / scale[:, None]
        columns = np.linalg.solve(inner, data).T / scale
        return cls(columns, np.zeros((len(columns), 0)), 0.0, places, exact, length)

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return _related(zeta, self.places, self.length)

    def rows(self, kept: np.ndarray) -> Self:
        return replace(super().rows(kept), exact=self.exact[:, kept])


def _related(zeta: np.ndarray, places: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Covariances of values with the value and the slopes at each place, and their slopes.

    Args:
        zeta: shape (p, d).
        places: shape (m, d).
        length: ℓ.

    Returns:
        Shapes (p, m (1 + d)) and (p, m (1 + d), d).
    """
    away = (zeta[:, None] - places) / length
    near = np.exp(-0.5 * (away**2).sum(axis=2))[..., None]
    value = np.concatenate([near, near * away / length], axis=2)
    first = -near * away / length
    outer = away[..., :, None] * away[..., None, :]
    second = near[..., None] * (np.eye(zeta.shape[1]) - outer) / length**2
    slopes = np.concatenate([first[:, :, None], second], axis=2)
    return value.reshape(len(zeta), -1), slopes.reshape(len(zeta), -1, zeta.shape[1])


@dataclass(frozen=True, eq=False)
class Straight(Emulator):
    """An emulator that goes on straight beyond where it was trained.

    Attributes:
        inner: the emulator.
        box: ranges of ζ that it was trained in, (d, 2).
    """

    inner: Emulator
    box: np.ndarray

    @classmethod
    def of(cls, inner: Emulator, box: np.ndarray) -> Straight:
        """Go on with an emulator beyond a box."""
        return cls(inner.columns, inner.errors, inner.ordinary, inner, box)

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        inside = np.clip(zeta, *self.box.T)
        value, slopes = self.inner.with_slopes(inside)
        return value + (slopes @ (zeta - inside)[..., None])[..., 0], slopes


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
        ordinary = float(np.linalg.norm([each.ordinary for each in parts]))
        return cls(np.hstack([each.columns for each in parts]), errors, ordinary, parts)

    def at(self, zeta: np.ndarray) -> np.ndarray:
        return np.hstack([each.at(zeta) for each in self.parts])

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values, slopes = zip(*(each.with_slopes(zeta) for each in self.parts), strict=True)
        return np.hstack(values), np.concatenate(slopes, axis=1)

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
    factor: Unknown

    @classmethod
    def of(cls, inner: Emulator, scaled: np.ndarray, factor: Unknown) -> Scaled:
        """Scale an emulator of a cause, whose readings are ``scaled`` or not, (n,)."""
        on = scaled[:, None]
        columns = np.hstack([inner.columns * on, inner.columns * ~on])
        return cls(columns, inner.errors, 2**0.5 * inner.ordinary, inner, factor)

    @classmethod
    def alone(cls, base: np.ndarray, scaled: np.ndarray, factor: Unknown) -> Scaled:
        """Make the emulator of what c changes about the model's readings (n,)."""
        return cls((base * scaled)[:, None], np.zeros((len(base), 0)), 0.0, None, factor)

    def at(self, zeta: np.ndarray) -> np.ndarray:
        c = self.factor.at(zeta[:, :1])
        if self.inner is None:
            return c - 1
        g = self.inner.at(zeta[:, 1:])
        return np.hstack([c * g, g])

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        c, rate = self.factor.at(zeta[:, :1]), self.factor.slope(zeta[:, :1])
        if self.inner is None:
            return c - 1, rate[..., None]
        g, slopes = self.inner.with_slopes(zeta[:, 1:])
        scaled = np.concatenate([(rate * g)[..., None], c[..., None] * slopes], axis=2)
        told = np.concatenate([np.zeros((*g.shape, 1)), slopes], axis=2)
        return np.hstack([c * g, g]), np.concatenate([scaled, told], axis=1)


@dataclass(frozen=True)
class Coordinate:
    """A coordinate that a change is a polynomial of.

    Attributes:
        value: by ζ, of the same shape.
        amplitude: whether the change vanishes with it.
        signed: whether an amplitude has either sign.
        of: which entry of ζ it is of, the moduli left out where these have a table.
        rate: its derivative by ζ where that is constant.
    """

    value: Callable[[np.ndarray], np.ndarray]
    amplitude: bool
    signed: bool = True
    of: int = 0
    rate: float | None = None

    @classmethod
    def within(cls, low: float, high: float, of: int = 0) -> Coordinate:
        """ζ itself from −1 to 1 between two values."""
        middle, half = (low + high) / 2, max((high - low) / 2, 1e-6)
        return cls(lambda zeta: (zeta - middle) / half, amplitude=False, of=of, rate=1 / half)

    def rates(self, zeta: np.ndarray) -> np.ndarray:
        """Derivatives by ζ, of its shape."""
        if self.rate is not None:
            return np.full(len(zeta), self.rate)
        step = POLICY.coordinate_step
        return (self.value(zeta + step) - self.value(zeta - step)) / (2 * step)


class Basis(ABC):
    """Functions of ζ whose weighted sum is a change.

    Attributes:
        coordinates: of the entries of ζ.
    """

    coordinates: tuple[Coordinate, ...]

    def __call__(self, zeta: np.ndarray) -> np.ndarray:
        """(places, m) at ζ, shape (places, d)."""
        return self.with_slopes(zeta)[0]

    @abstractmethod
    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values at ζ, (places, m), and derivatives by it, (places, m, d).

        Args:
            zeta: shape (places, d).
        """

    def _values(self, zeta: np.ndarray) -> np.ndarray:
        """(places, coordinates)."""
        found = np.empty((len(zeta), len(self.coordinates)))
        for place, each in enumerate(self.coordinates):
            found[:, place] = each.value(zeta[:, each.of])
        return found


@dataclass(frozen=True, eq=False)
class Pieces(Basis):
    """Cubic pieces of one amplitude between places where value and slope are known.

    A change may turn at once, where a contact moves to another edge: there a polynomial bends away
    to either side, and pieces are wrong in one of them. A change vanishes where the amplitude does,
    and may have another slope on either side of it; the pieces beside that place are parabolas. It
    goes on straight beyond the outermost places.

    Attributes:
        coordinates: whose sum is the amplitude.
        pieces: values of all functions, and derivatives, by the amplitude.
    """

    coordinates: tuple[Coordinate, ...]
    pieces: BPoly

    @classmethod
    def of(cls, coordinates: Sequence[Coordinate], zeta: np.ndarray) -> Pieces:
        """Pieces between m places: 2 m functions, of which each is one value or slope there.

        Args:
            coordinates: whose sum is the amplitude.
            zeta: the places, shape (m, 1).
        """
        u = np.sum([each.value(zeta[:, 0]) for each in coordinates], axis=0)
        unit = np.eye(2 * len(zeta))
        known = {float(at): [unit[i], unit[len(zeta) + i]] for i, at in enumerate(u)}
        known[0.0] = [np.zeros(len(unit))]
        ordered = sorted(known)
        return cls(
            tuple(coordinates), BPoly.from_derivatives(ordered, [known[at] for at in ordered])
        )

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        u = self._values(zeta).sum(axis=1)
        rates = np.sum([each.rates(zeta[:, 0]) for each in self.coordinates], axis=0)
        inside = np.clip(u, self.pieces.x[0], self.pieces.x[-1])
        by_u = self.pieces(inside, 1)
        value = self.pieces(inside) + by_u * (u - inside)[:, None]
        return value, (by_u * rates[:, None])[..., None]


@dataclass(frozen=True, eq=False)
class Polynomial(Basis):
    """Monomials of u / (1 + q · u), u being coordinates of ζ.

    What stiffens a body changes its readings the less, the stiffer it is already: a compliance is
    1 / (1 + q · u). So this map makes the change of a strong effect nearly straight.

    Attributes:
        coordinates: of the entries of ζ.
        exponents: of the coordinates, shape (m, coordinates).
        pole: q, shape (coordinates,).
    """

    coordinates: tuple[Coordinate, ...]
    exponents: np.ndarray
    pole: np.ndarray

    @classmethod
    def of(cls, coordinates: Sequence[Coordinate], degree: int, pole: np.ndarray) -> Polynomial:
        """All monomials up to a degree that have an amplitude; any where there is no amplitude."""
        d = len(coordinates)
        some = np.array([each.amplitude for each in coordinates], dtype=bool)
        kept = [row for row in exponents_up_to(degree, d) if not any(some) or row[some].sum() > 0]
        # of an amplitude that differs to either side one side is 0 where the other is not
        of = np.array([each.of for each in coordinates])
        kept = [row for row in kept if len(set(of[row > 0])) == (row > 0).sum()]
        return cls(tuple(coordinates), np.array(kept, dtype=int).reshape(len(kept), d), pole)

    def __call__(self, zeta: np.ndarray) -> np.ndarray:
        """(places, m) at ζ, shape (places, d)."""
        values = self._values(zeta)
        return monomials(values / self._divisors(values), self.exponents)

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values = self._values(zeta)
        by = self._divisors(values)
        found, by_coordinate = monomials_with_slopes(values / by, self.exponents)
        if self.pole.any():
            along = np.einsum("pmc,pc->pm", by_coordinate, values / by)
            along = along * (by > POLICY.nearest_pole)
            by_coordinate = (by_coordinate - along[..., None] * self.pole) / by[..., None]
        slopes = np.zeros((*found.shape, zeta.shape[1]))
        for place, each in enumerate(self.coordinates):
            rates = each.rates(zeta[:, each.of])[:, None]
            slopes[..., each.of] += by_coordinate[..., place] * rates
        return found, slopes

    def _divisors(self, values: np.ndarray) -> np.ndarray:
        """1 + q · u, (places, 1); no nearer to the pole than a small number."""
        return np.maximum(1 + values @ self.pole, POLICY.nearest_pole)[:, None]


@dataclass(frozen=True, eq=False)
class PolynomialEmulator(Emulator):
    """A polynomial of coordinates of ζ, or pieces of polynomials.

    Attributes:
        left: root mean square error of a simulation that was left out, by the noise.
        basis: of the entries of ζ, without the first where there is a ``table``.
        weights: shape (m, k); those of the middle node where there is a ``table``.
        table: weights by the first entry of ζ, (m, k); None where these are constant.
    """

    left: float
    basis: Basis
    weights: np.ndarray
    table: CubicSpline | None

    def at(self, zeta: np.ndarray) -> np.ndarray:
        zeta = np.asarray(zeta, dtype=float)
        if self.table is None:
            return np.asarray(self.basis(zeta) @ self.weights)
        inside = np.clip(zeta[:, 0], self.table.x[0], self.table.x[-1])
        return np.asarray(np.einsum("im,imk->ik", self.basis(zeta[:, 1:]), self.table(inside)))

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if self.table is None:
            basis, slopes = self.basis.with_slopes(zeta)
            return basis @ self.weights, self.weights.T @ slopes
        basis, slopes = self.basis.with_slopes(zeta[:, 1:])
        inside = np.clip(zeta[:, 0], self.table.x[0], self.table.x[-1])
        weights = self.table(inside)
        first = np.einsum("pm,pmk->pk", basis, self.table(inside, 1))
        every = np.concatenate([first[..., None], weights.transpose(0, 2, 1) @ slopes], axis=2)
        return np.einsum("pm,pmk->pk", basis, weights), every


@dataclass(frozen=True, eq=False)
class SimulatedChanges:
    """Simulated changes of one cause.

    Attributes:
        zeta: places, shape (places, d); of the cause's numbers, the moduli's first where
            ``nodes`` is None and they are among the coordinates.
        values: (nodes or 1, places, n) changes.
        slopes: (nodes or 1, places, d, n) derivatives by ζ; NaN where unknown.
        nodes: ζ of the moduli at which each simulation was read; None where it was at one.
    """

    zeta: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    nodes: np.ndarray | None

    def beside(self, more: SimulatedChanges) -> SimulatedChanges:
        """Return these and others of the same cause, read at the same moduli."""
        return replace(
            self, zeta=np.vstack([self.zeta, more.zeta]),
            values=np.concatenate([self.values, more.values], axis=1),
            slopes=np.concatenate([self.slopes, more.slopes], axis=1),
        )  # fmt: skip


def trained_on(
    simulations: SimulatedChanges,
    coordinates: Sequence[Coordinate],
    scale: np.ndarray,
    *,
    degree: int = POLICY.curved_degree,
    share: float = POLICY.curved_share,
    left_out: Sequence[np.ndarray] | None = None,
) -> PolynomialEmulator:
    """An emulator, of that degree and pole, or of pieces, that leave least of what was left out.

    Where there is no amplitude there is no pole, and the degree is the highest.

    Args:
        simulations: values and derivatives.
        coordinates: of ζ.
        scale: noise of the readings, shape (n,).
        degree: of the polynomial, at most.
        share: most monomials by the number of values and derivatives; 1: the polynomial may go
            through all, and keeps more components.
        left_out: which places are left out of a fit at a time, and tell its error, (places,) of
            bool; each in turn where None. Where there are none there is no error.
    """
    zeta, white, n = simulations.zeta, simulations.values / scale, len(scale)
    folds = np.eye(len(zeta), dtype=bool) if left_out is None else left_out
    # the moduli at their middle count as much as all others
    components = principal(white.reshape(-1, n), POLICY.components * (2 if share == 1.0 else 1))
    known = np.isfinite(simulations.slopes).all(axis=(0, 1, 3))
    slopes = POLICY.slope_weight * (simulations.slopes[:, :, known] / scale @ components.T)
    target = np.concatenate([white @ components.T, *np.moveaxis(slopes, 2, 0)], axis=1)
    middle = len(white) // 2
    truncated = white[middle] - white[middle] @ components.T @ components
    # what a simulation tells of itself is no longer left out
    off = zeta - np.clip(0.0, zeta.min(axis=0), zeta.max(axis=0))

    def design(basis: Basis) -> np.ndarray:
        value, rates = basis.with_slopes(zeta)
        return np.vstack([value, *(POLICY.slope_weight * np.moveaxis(rates[:, :, known], 2, 0))])

    def beside(out: np.ndarray) -> np.ndarray:
        """Residuals of some places beside pieces between all others."""
        own = design(Pieces.of(coordinates, zeta[~out]))
        rows = np.tile(out, len(own) // len(out))
        weights = np.linalg.lstsq(own[~rows], target[middle][~rows], rcond=_RCOND)[0]
        return np.asarray(target[middle][rows] - own[rows] @ weights)[: out.sum()]

    def judged(basis: Basis) -> tuple[np.ndarray, float]:
        """Columns of the error, and its root mean square, by what was left out."""
        if isinstance(basis, Pieces):
            rest = [beside(out) for out in folds]
        else:
            rest = _left_out(design(basis), target[middle], folds)
        every = np.vstack(
            [each @ components + truncated[out] for each, out in zip(rest, folds, strict=True)]
        )
        return error_of(every, np.vstack([off[out] for out in folds]), scale)

    vanishes = any(each.amplitude for each in coordinates)
    straight = Polynomial.of(coordinates, 1, np.zeros(len(coordinates)))
    every = [
        straight,
        *(Polynomial.of(coordinates, i, straight.pole) for i in range(2, degree + 1)),
    ]
    every = [each for each in every if len(each.exponents) <= share * target.shape[1]] or [straight]
    chosen: Basis = every[-1]
    errors, left = np.zeros((n, 0)), 0.0
    if len(folds):
        poles = [straight.pole]
        if vanishes:
            poles += _poles(straight, design, target[middle, :, 0], zeta)
        else:
            every = every[-1:]
        tried: list[Basis] = [replace(each, pole=pole) for each in every for pole in poles]
        amplitudes = all(each.amplitude for each in coordinates)
        if amplitudes and zeta.shape[1] == 1 < len(zeta) and known.all():
            tried.append(Pieces.of(coordinates, zeta))
        chosen, (errors, left) = min(
            ((each, judged(each)) for each in tried), key=lambda pair: pair[1][1]
        )
    ordinary = error_of(white[middle], off, scale)[1] * n**0.5 if vanishes else 0.0
    inverse = np.linalg.pinv(design(chosen), rcond=_RCOND)
    weights = np.einsum("mp,npk->nmk", inverse, target)
    table = None if simulations.nodes is None else CubicSpline(simulations.nodes, weights)
    return PolynomialEmulator(
        components.T * scale[:, None], errors, ordinary, left, chosen, weights[middle], table
    )


_RCOND: Final = 1e-8


def _left_out(
    design: np.ndarray, target: np.ndarray, folds: Sequence[np.ndarray] | np.ndarray
) -> list[np.ndarray]:
    """Residuals of some places beside a fit to all others.

    They are beside a fit to all places where too few others are left.
    The fit that leaves rows out has the residual (1 − H)⁻¹ r there (Cook & Weisberg, Residuals and
    Influence in Regression, 1982, section 2.2).
    """
    left, sizes, _ = np.linalg.svd(design, full_matrices=False)
    left = left[:, sizes > _RCOND * sizes[0]]
    rest, found = target - left @ (left.T @ target), []
    for out in folds:
        rows = np.tile(out, len(design) // len(out))
        own = rest[rows]
        if (~rows).sum() >= design.shape[1]:
            others = np.eye(len(own)) - left[rows] @ left[rows].T
            own = np.linalg.lstsq(others, own, rcond=_RCOND)[0]
        found.append(own[: out.sum()])
    return found


def _poles(
    straight: Polynomial,
    design: Callable[[Polynomial], np.ndarray],
    target: np.ndarray,
    zeta: np.ndarray,
) -> list[np.ndarray]:
    """q along which A u / (1 + q · u) is nearest to the changes, of several lengths; 0 of shapes.

    A stiffness that is linear in u has q in proportion to A.
    """
    u, found = straight(zeta), []
    for length in (sign * each for each in POLICY.poles for sign in (1.0, -1.0)):
        trial, q = straight, np.zeros(u.shape[1])
        for _ in range(POLICY.pole_steps):
            along = np.linalg.lstsq(design(trial), target, rcond=_RCOND)[0]
            q = length * along / max(float(np.abs(u @ along).max()), 1e-300)
            trial = replace(straight, pole=q @ straight.exponents)
        if (1 + u @ q).min() > POLICY.nearest_pole:
            found.append(trial.pole)
    return found


def turning(simulations: SimulatedChanges, neutral: float, scale: np.ndarray) -> np.ndarray:
    """Places between those of one number where its change turns most, shape (places, 1).

    Between two places a cubic piece is off their chord by an eighth of their distance and of what
    the slope changes by, and so is wrong by less. The worst pieces are cut in half.

    Args:
        simulations: values and derivatives.
        neutral: ζ at which the cause changes nothing, a place that is known without a simulation.
        scale: noise of the readings, shape (n,).
    """
    middle, order = len(simulations.values) // 2, np.argsort(simulations.zeta[:, 0])
    zeta = simulations.zeta[order, 0]
    value, slope = (
        each[middle, order] / scale for each in (simulations.values, simulations.slopes[:, :, 0])
    )
    ends, turned = np.column_stack([zeta[:-1], zeta[1:]]), np.diff(slope, axis=0)
    over = (ends[:, 0] < neutral) & (neutral < ends[:, 1])
    if over.any():  # a parabola on either side of it
        beside = np.flatnonzero(over)[0] + np.array([0, 1])
        by = zeta[beside] - neutral
        ends = np.vstack([ends[~over], np.column_stack([np.full(2, neutral), zeta[beside]])])
        turned = np.vstack([turned[~over], 2 * (slope[beside] - value[beside] / by[:, None])])
    wrong = np.sqrt(np.square(turned).mean(axis=1)) * np.abs(ends[:, 1] - ends[:, 0]) / 8
    centre = ends.mean(axis=1)
    worst = np.argsort(-wrong * np.exp(-0.25 * centre**2))[: POLICY.at_once]
    return np.asarray(centre[worst][:, None])


def trained(
    zeta: np.ndarray, changes: np.ndarray, scale: np.ndarray, box: np.ndarray
) -> PolynomialEmulator:
    """An emulator from many simulated changes without derivatives.

    Args:
        zeta: shape (places, d).
        changes: shape (places, n).
        scale: noise of the readings, shape (n,).
        box: ranges of ζ, shape (d, 2).
    """
    count, d = zeta.shape
    own = [Coordinate.within(float(low), float(high), i) for i, (low, high) in enumerate(box)]
    slopes = np.full((1, count, d, changes.shape[1]), np.nan)
    return trained_on(
        SimulatedChanges(zeta, changes[None], slopes, None), own, scale,
        degree=POLICY.degrees[min(d, len(POLICY.degrees)) - 1],
        share=0.5,  # which half of the simulations can tell
        left_out=[np.arange(count) % POLICY.left_out == POLICY.left_out - 1],
    )  # fmt: skip


def linear(change: np.ndarray) -> Emulator:
    """Make an emulator of one number from its change by one standard deviation, shape (n,)."""
    none, own = np.zeros((len(change), 0)), (Coordinate.within(-1.0, 1.0),)
    first = Polynomial(own, np.array([[1]]), np.zeros(1))
    return PolynomialEmulator(change[:, None], none, 0.0, 0.0, first, np.ones((1, 1)), None)


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
    """(places, m) of u, shape (places, d), and derivatives by it, (places, m, d)."""
    orders, rows = np.arange(exponents.max(initial=0) + 1), np.arange(u.shape[1])
    powers = u[:, :, None] ** orders
    down = np.zeros_like(powers)
    down[..., 1:] = powers[..., :-1] * orders[1:]
    each, changed = powers[:, rows, exponents], down[:, rows, exponents]
    before, after = np.ones_like(each), np.ones_like(each)
    for i in rows[1:]:
        before[..., i] = before[..., i - 1] * each[..., i - 1]
        after[..., -1 - i] = after[..., -i] * each[..., -i]
    return each.prod(axis=2), before * changed * after
