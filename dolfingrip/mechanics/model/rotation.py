"""Rotations by a rotation vector, and their first and second derivatives."""

from __future__ import annotations

from math import factorial
from typing import Final, NamedTuple

import numpy as np

LEVI_CIVITA: Final = np.array(
    [[[(i - j) * (j - k) * (k - i) / 2 for k in range(3)] for j in range(3)] for i in range(3)]
)

SERIES: Final = 1.0
"""|θ|² below which the factors are series, which are regular at θ = 0."""

TERMS: Final = 12
"""Number of terms of the series; the first one that is left out is below 1e-24."""

POWERS: Final = np.array(
    [
        [
            [
                (-1) ** (n + order) * factorial(n + order) / factorial(n)
                / factorial(2 * (n + order) + first)
                for n in range(TERMS)
            ]
            for first in range(3)
        ]
        for order in range(3)
    ]
)  # fmt: skip
"""Factors of qⁿ in the derivatives by q, of order 0, 1 and 2, of Σ (−q)ⁿ/(2n + first)!.

The sums are c, a and b for first = 0, 1 and 2.
"""


class Rotation(NamedTuple):
    """R = exp(θ×) and its derivatives by θ.

    Quantities that turn with a body have the form φ(θ) = R(θ) : M = Σ R_ij M_ij for some M (3, 3);
    its derivatives are those of R, contracted with M.

    Attributes:
        matrix: R, (3, 3).
        first: ∂R_ij/∂θ_k at [k, i, j].
        second: ∂²R_ij/∂θ_k∂θ_l at [k, l, i, j].
    """

    matrix: np.ndarray
    first: np.ndarray
    second: np.ndarray

    @property
    def inverse(self) -> Rotation:
        """Rᵀ and its derivatives by θ."""
        first, second = self.first.transpose(0, 2, 1), self.second.transpose(0, 1, 3, 2)
        return Rotation(self.matrix.T, first, second)

    def slopes(self, m: np.ndarray) -> np.ndarray:
        """(3,) derivatives of R : M."""
        return np.einsum("kij,ij->k", self.first, m)

    def curvatures(self, m: np.ndarray) -> np.ndarray:
        """(3, 3) second derivatives of R : M."""
        return np.einsum("klij,ij->kl", self.second, m)


def rotation(theta: np.ndarray) -> Rotation:
    """The rotation by |θ| about the vector θ (rad), and its derivatives.

    Rodrigues' formula R = c 1 + a θ× + b θ⊗θ with c = cos|θ|, a = sin|θ|/|θ| and
    b = (1 − cos|θ|)/|θ|², smooth functions of |θ|² (Argyris, Comput. Methods Appl. Mech.
    Eng. 32, 1982). R is regular in θ up to |θ| = 2π, where ∂R/∂θ loses rank.
    """
    theta = np.asarray(theta, dtype=float)
    (c, a, b), (c1, a1, b1), (c2, a2, b2) = _factors(float(theta @ theta))
    one, spin = np.eye(3), -np.einsum("ijk,k->ij", LEVI_CIVITA, theta)
    square = np.outer(theta, theta)
    # ∂(θ⊗θ)_ij/∂θ_k at [k, i, j], and its derivative by θ_l
    turn = -np.einsum("ijk->kij", LEVI_CIVITA)
    sides = np.einsum("ki,j->kij", one, theta) + np.einsum("kj,i->kij", one, theta)
    both = np.einsum("ki,lj->klij", one, one) + np.einsum("kj,li->klij", one, one)
    inner = c1 * one + a1 * spin + b1 * square
    inner_rate = c2 * one + a2 * spin + b2 * square
    matrix = c * one + a * spin + b * square
    first = 2 * np.einsum("k,ij->kij", theta, inner) + a * turn + b * sides
    across = np.einsum("k,lij->klij", 2 * theta, a1 * turn + b1 * sides)
    second = (
        2 * np.einsum("kl,ij->klij", one, inner)
        + 4 * np.einsum("k,l,ij->klij", theta, theta, inner_rate)
        + across
        + across.transpose(1, 0, 2, 3)
        + b * both
    )
    return Rotation(matrix, first, second)


def _factors(q: float) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """c, a and b at q = |θ|², and their first and second derivatives by q."""
    if q < SERIES:
        found = (POWERS @ q ** np.arange(TERMS)).tolist()
        return tuple(found[0]), tuple(found[1]), tuple(found[2])
    angle = np.sqrt(q)
    c, a = np.cos(angle), np.sin(angle) / angle
    b = (1 - c) / q
    c1, a1 = -a / 2, (c - a) / (2 * q)
    b1 = (a / 2 - b) / q
    c2, a2, b2 = -a1 / 2, -(a / 2 + 3 * a1) / (2 * q), (a1 / 2 - 2 * b1) / q
    return (c, a, b), (c1, a1, b1), (c2, a2, b2)
