"""Quantities that a potential keeps fixed while it is minimised, though they change with u."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Protocol

import numpy as np

from dolfingrip.mechanics.model.unknowns import Gradient


class LaggedCorrection(Protocol):
    """Change C of a gradient along a step by the change of a term's lagged quantities.

    It is without the part that the tangent has, which is for fixed ones. Steps are local arrays of
    the unknowns.
    """

    def linearise(self, step: np.ndarray, *, convex: bool) -> None:
        """Take the derivative of C at ``step``, or of what majorises its potential there."""
        ...

    def add_change(self, step: np.ndarray, gradient: Gradient) -> None:
        """Add C(step) (N)."""
        ...

    def add_rate(self, step: np.ndarray, rate: Gradient) -> None:
        """Add the derivative of C along ``step``, at where it was taken last, at first 0."""
        ...


class Lagged(ABC):
    """A term with lagged quantities, such as friction with its normal forces.

    Displacements are local arrays of degrees of freedom, ghosts included (mm).
    """

    @abstractmethod
    def update_lagged(self, dofs: np.ndarray) -> bool:
        """Update the lagged quantities from the displacement ``dofs``.

        Newton's method asks for it in its first iterations.

        Returns:
            Whether the potential has changed, the same on all ranks.
        """

    @abstractmethod
    def lag_error(self, dofs: np.ndarray) -> float:
        """Relative change of lagged quantities since the last update, the same on all ranks."""

    @abstractmethod
    def lagged_correction(self, dofs: np.ndarray) -> LaggedCorrection | None:
        """How the gradient changes along a step from ``dofs`` by the change of lagged quantities.

        None where there are none at present.
        """

    @abstractmethod
    def lagged_state(self) -> Any:
        """The lagged quantities, which a state does not contain."""

    @abstractmethod
    def restore_lagged(self, state: Any) -> None:
        """Set the lagged quantities to what :meth:`lagged_state` gave."""
