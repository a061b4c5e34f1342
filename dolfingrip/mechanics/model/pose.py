"""The pose of a rigid body, whose coordinates are global unknowns or constants.

Rotations are by a rotation vector, with their first and second derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial
from typing import Final, NamedTuple

import numpy as np
from dolfinx import fem

from dolfingrip.mechanics.model.term import Coupling, global_coupling
from dolfingrip.mechanics.model.unknowns import GlobalUnknown, Gradient

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
        """Derivatives of R : M, (3,)."""
        return np.einsum("kij,ij->k", self.first, m)

    def curvatures(self, m: np.ndarray) -> np.ndarray:
        """Second derivatives of R : M, (3, 3)."""
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
        series = (POWERS @ q ** np.arange(TERMS)).tolist()
        return tuple(series[0]), tuple(series[1]), tuple(series[2])
    angle = np.sqrt(q)
    c, a = np.cos(angle), np.sin(angle) / angle
    b = (1 - c) / q
    c1, a1 = -a / 2, (c - a) / (2 * q)
    b1 = (a / 2 - b) / q
    c2, a2, b2 = -a1 / 2, -(a / 2 + 3 * a1) / (2 * q), (a1 / 2 - 2 * b1) / q
    return (c, a, b), (c1, a1, b1), (c2, a2, b2)


SIX = 6
"""Coordinates of a rigid body: its centre (mm), then its rotation vector (rad)."""


class Pose:
    """The centre c (mm) and rotation vector θ (rad) of a rigid body: q = q₀ + B a.

    Points X of the body are at c + R(θ) X. The coordinates a are constants, and each may be a
    global unknown. All six are unknowns for a free body, one for a plate that slides along its
    normal, and none for a body that stands still.

    Args:
        constants: the m coordinates a.
        basis: (6, m) B.
        base: (6,) q₀.
        global_unknowns: global unknowns of the coordinates; None for each prescribed one.

    Attributes:
        global_unknowns: these unknowns, which may be changed until a model is made.
    """

    def __init__(
        self,
        constants: Sequence[fem.Constant],
        basis: np.ndarray,
        base: np.ndarray,
        global_unknowns: Sequence[GlobalUnknown | None] = (),
    ) -> None:
        self.constants = tuple(constants)
        self._basis = np.asarray(basis, dtype=float).reshape(SIX, len(self.constants))
        self._base = np.asarray(base, dtype=float)
        self.global_unknowns: list[GlobalUnknown | None] = list(global_unknowns) or [None] * len(
            self.constants
        )

    @property
    def coordinates(self) -> np.ndarray:
        """Present q, (6,)."""
        return self._base + self._basis @ [float(constant.value) for constant in self.constants]

    @property
    def free(self) -> list[GlobalUnknown]:
        """The coordinates that are solved for."""
        return [unknown for unknown in self.global_unknowns if unknown is not None]

    @property
    def _free_basis(self) -> np.ndarray:
        """Columns of B for the coordinates that are solved for, (6, m')."""
        return self._basis[:, [unknown is not None for unknown in self.global_unknowns]]

    def change(self, step: np.ndarray) -> np.ndarray:
        """Change of q by a local array of the unknowns, (6,)."""
        return np.asarray(self._free_basis @ [unknown.change(step) for unknown in self.free])

    def rate(self, constant: fem.Constant) -> np.ndarray:
        """Derivative of q by one of the coordinates, (6,); 0 by any other constant."""
        same = [float(other is constant) for other in self.constants]
        return np.asarray(self._basis @ same)

    def add_slopes(self, slopes: np.ndarray, gradient: Gradient) -> None:
        """Add a potential's (6,) derivatives by q, which are equal on all ranks."""
        for unknown, slope in zip(self.free, self._free_basis.T @ slopes, strict=True):
            gradient.add(unknown, float(slope))

    def coupling(self, first: int, mixed: np.ndarray, within: np.ndarray) -> list[Coupling]:
        """The coupling of the coordinates that are solved for; empty if there are none.

        Args:
            first: this rank's first displacement node.
            mixed: (6, 3n) derivatives by q and this rank's owned displacements.
            within: (6, 6) derivatives by q, the same on all ranks.
        """
        if not self.free:
            return []
        basis = self._free_basis
        return [global_coupling(self.free, first, basis.T @ mixed, basis.T @ within @ basis)]
