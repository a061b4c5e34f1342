"""The pose of a rigid body, whose coordinates are global unknowns or constants."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem

from dolfingrip.mechanics.model.term import Coupling, global_coupling
from dolfingrip.mechanics.model.unknowns import GlobalUnknown, Gradient

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
        """(6,) present q."""
        return self._base + self._basis @ [float(constant.value) for constant in self.constants]

    @property
    def free(self) -> list[GlobalUnknown]:
        """The coordinates that are solved for."""
        return [unknown for unknown in self.global_unknowns if unknown is not None]

    @property
    def _free_basis(self) -> np.ndarray:
        """(6, m') columns of B for the coordinates that are solved for."""
        return self._basis[:, [unknown is not None for unknown in self.global_unknowns]]

    def change(self, step: np.ndarray) -> np.ndarray:
        """(6,) change of q by a local array of the unknowns."""
        return np.asarray(self._free_basis @ [unknown.change(step) for unknown in self.free])

    def rate(self, constant: fem.Constant) -> np.ndarray:
        """(6,) derivative of q by one of the coordinates; 0 by any other constant."""
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
