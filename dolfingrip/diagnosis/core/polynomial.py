"""Emulators of changes that depend on the moduli, too, by few simulations and slopes.

    Δ(ζ_m, ζ) = Φ Σ_j w_j(ζ_m) P_j(u(ζ))

u are coordinates in which a change is nearly straight: an amplitude by its ordinary value, warped;
a shape's own ζ. Every monomial P_j has at least one amplitude, so that a cause of no strength
changes nothing. The weights are splines of the moduli where these scale a simulation exactly, else
the moduli are one more coordinate of the polynomial. Values and derivatives are fitted together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from dolfingrip.diagnosis.core.emulator import (
    Emulator,
    error_of,
    exponents_up_to,
    monomials,
    monomials_with_slopes,
    principal,
)
from dolfingrip.diagnosis.policy import POLICY

Warp = Callable[[np.ndarray], np.ndarray]

WARPS: Final[tuple[Warp, ...]] = (
    lambda a: a,
    lambda a: np.log1p(np.maximum(a, -0.9)),
    lambda a: a / (1 + np.maximum(a, -0.5)),
    lambda a: 4 * a / (1 + 4 * np.maximum(a, -0.1)),
)
"""Warps of amplitudes by their ordinary value; the first for those of either sign."""


@dataclass(frozen=True)
class Coordinate:
    """A coordinate that a change is a polynomial of.

    Attributes:
        value: by ζ, of the same shape.
        amplitude: whether the change vanishes with it.
        signed: whether an amplitude has either sign.
        of: which entry of ζ it is of, the moduli left out where these have a table.
    """

    value: Callable[[np.ndarray], np.ndarray]
    amplitude: bool
    signed: bool = True
    of: int = 0

    def warped(self, warp: Warp) -> Coordinate:
        """An amplitude of one sign in other units."""
        if not self.amplitude or self.signed:
            return self
        inner = self.value
        return replace(self, value=lambda zeta: warp(inner(zeta)))


@dataclass(frozen=True, eq=False)
class CurvedEmulator(Emulator):
    """A polynomial of coordinates of ζ.

    Attributes:
        exponents: of the coordinates, shape (m, coordinates).
        weights: shape (m, k); those of the middle node where there is a ``table``.
        coordinates: of the entries of ζ, without the first where there is a ``table``.
        table: weights by the first entry of ζ, (m, k); None where these are constant.
    """

    exponents: np.ndarray
    weights: np.ndarray
    coordinates: tuple[Coordinate, ...]
    table: CubicSpline | None

    def at(self, zeta: np.ndarray) -> np.ndarray:
        zeta = np.asarray(zeta, dtype=float)
        if self.table is None:
            return np.asarray(self._basis(zeta) @ self.weights)
        inside = np.clip(zeta[:, 0], self.table.x[0], self.table.x[-1])
        return np.asarray(np.einsum("im,imk->ik", self._basis(zeta[:, 1:]), self.table(inside)))

    def with_slopes(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        first = self.table is not None
        own = zeta[1:] if first else zeta
        weights = self.weights
        slopes = []
        (u,), (rates,) = _with_rates(self.coordinates, own[None])
        basis, derived_by = monomials_with_slopes(u, self.exponents)
        if self.table is not None:
            inside = float(np.clip(zeta[0], self.table.x[0], self.table.x[-1]))
            weights = self.table(inside)
            slopes.append(basis @ self.table(inside, 1))
        nuisance_change = np.zeros((len(own), weights.shape[1]))
        for each, rate, column in zip(self.coordinates, rates, derived_by.T, strict=True):
            nuisance_change[each.of] += rate * column @ weights
        return basis @ weights, np.array([*slopes, *nuisance_change]).reshape(
            -1, weights.shape[1]
        ).T

    def _basis(self, zeta: np.ndarray) -> np.ndarray:
        """(places, m)."""
        return monomials(_values(self.coordinates, zeta), self.exponents)


def _values(coordinates: Sequence[Coordinate], zeta: np.ndarray) -> np.ndarray:
    """(places, coordinates)."""
    found = np.zeros((len(zeta), len(coordinates)))
    for i, each in enumerate(coordinates):
        found[:, i] = each.value(zeta[:, each.of])
    return found


def _with_rates(
    coordinates: Sequence[Coordinate], zeta: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and their derivatives by the entry of ζ of each, (places, coordinates) each."""
    every = np.vstack([zeta + by for by in (-POLICY.coordinate_step, 0.0, POLICY.coordinate_step)])
    less, here, more = np.split(_values(coordinates, every), 3)
    return here, (more - less) / (2 * POLICY.coordinate_step)


def derived(u: np.ndarray, exponents: np.ndarray, i: int) -> np.ndarray:
    """(places, m) derivatives of the monomials by the i-th coordinate."""
    lower = exponents.copy()
    lower[:, i] = np.maximum(lower[:, i] - 1, 0)
    return np.asarray(monomials(u, lower) * exponents[:, i])


def exponents_of(coordinates: Sequence[Coordinate], degree: int) -> np.ndarray:
    """All monomials up to a degree that have an amplitude; any where there is no amplitude."""
    d = len(coordinates)
    some = np.array([each.amplitude for each in coordinates], dtype=bool)
    kept = [row for row in exponents_up_to(degree, d) if not any(some) or row[some].sum() > 0]
    # of an amplitude that differs to either side one side is 0 where the other is not
    of = np.array([each.of for each in coordinates])
    kept = [row for row in kept if len(set(of[row > 0])) == (row > 0).sum()]
    return np.array(kept, dtype=int).reshape(len(kept), d)


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


def trained_on(
    simulations: SimulatedChanges,
    coordinates: Sequence[Coordinate],
    scale: np.ndarray,
    takes: tuple[int, ...],
    *,
    exact: bool = False,
    degree: int = POLICY.curved_degree,
) -> CurvedEmulator:
    """An emulator, in the warped amplitudes that leave least of what was left out.

    Args:
        simulations: values and derivatives.
        coordinates: of ζ.
        scale: noise of the readings, shape (n,).
        takes: which of the model's own numbers come first in ζ.
        degree: of the polynomial, at most.
        exact: go through all places, without an error, as where these are a formula's.
    """
    one_sided = any(each.amplitude and not each.signed for each in coordinates)
    warps = WARPS if one_sided else WARPS[:1]
    found = [
        _trained(simulations, [c.warped(warp) for c in coordinates], scale, takes, exact, degree)
        for warp in warps
    ]
    return min(found, key=lambda each: each.left)


def _trained(
    told: SimulatedChanges,
    coordinates: Sequence[Coordinate],
    scale: np.ndarray,
    takes: tuple[int, ...],
    exact: bool,
    degree: int,
) -> CurvedEmulator:
    places, d = told.zeta.shape
    n = len(scale)
    white = told.values / scale
    white_slopes = told.slopes / scale
    # the moduli at their middle count as much as all others
    basis = principal(white.reshape(-1, n), 2 * POLICY.components if exact else POLICY.components)
    u, du = _with_rates(coordinates, told.zeta)
    known = [i for i in range(d) if np.isfinite(told.slopes[:, :, i]).all()]
    size = places * (1 + len(known))
    most = 1.0 if exact else POLICY.curved_share
    while degree > 1 and len(exponents_of(coordinates, degree)) > most * size:
        degree -= 1
    exponents = exponents_of(coordinates, degree)
    matrix = [monomials(u, exponents)]
    matrix += [
        POLICY.slope_weight * np.sum(
            [derived(u, exponents, j) * du[:, j, None] for j, c in enumerate(coordinates)
             if c.of == i], axis=0,
        )
        for i in known
    ]  # fmt: skip
    design = np.vstack(matrix)
    scores = white @ basis.T
    slope_scores = [white_slopes[:, :, i] @ basis.T * POLICY.slope_weight for i in known]
    target = np.concatenate([scores, *slope_scores], axis=1)
    middle = len(white) // 2

    def solve(kept: np.ndarray, at: slice) -> np.ndarray:
        every = np.tile(kept, 1 + len(known))
        inverse = np.linalg.pinv(design[every], rcond=1e-8)
        return np.einsum("mp,npk->nmk", inverse, target[at][:, every])

    weights = solve(np.ones(places, bool), slice(None))
    rest = []
    for left_out in range(0 if exact else places):
        kept = np.arange(places) != left_out
        if kept.sum() * (1 + len(known)) < len(exponents):
            rest.append(white[middle, left_out] - matrix[0][left_out] @ weights[middle] @ basis)
            continue
        own = solve(kept, slice(middle, middle + 1))[0]
        rest.append(white[middle, left_out] - matrix[0][left_out] @ own @ basis)
    table = None if told.nodes is None else CubicSpline(told.nodes, weights)
    errors, left = np.zeros((n, 0)), 0.0
    if not exact:  # what a simulation tells of itself is no longer left out
        errors, left = error_of(np.array(rest), told.zeta, scale)
    return CurvedEmulator(
        basis.T * scale[:, None], errors, left, exponents, weights[middle], tuple(coordinates),
        table, takes=takes,
    )  # fmt: skip
