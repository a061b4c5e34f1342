"""Equations and unknowns beside the displacement's."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from petsc4py import PETSc


class Border(Protocol):
    """Equations and unknowns that border the displacement's in Newton's method.

    Attributes:
        force_N: scale of the residual that they bring, 0 where none.
    """

    force_N: float

    def met(self, tolerance: float) -> bool:
        """Whether their equations hold to a relative ``tolerance``."""
        ...

    def correct(self, y: PETSc.Vec, ksp: PETSc.KSP) -> None:
        """Make SNES' step (x − y) with the unknowns fixed one of the bordered system."""
        ...

    def limit(self, step: np.ndarray, fraction: float) -> float:
        """At most ``fraction`` of ``step`` (local dofs, mm), bounded by their change.

        Negative where the step is taken backwards, their change with it.
        """
        ...

    def advance(self, fraction: float) -> None:
        """Take ``fraction`` of their change."""
        ...
