"""Quantities that depend on u, but that a potential keeps fixed while it is minimised."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Protocol

import numpy as np

from dolfingrip.mechanics.model.unknowns import Gradient


class LaggedCorrection(Protocol):
    """Change C of a gradient along a step that is due to the change of lagged quantities.

    The change for fixed lagged quantities is not part of C; the tangent has it. Steps are local
    arrays of the unknowns.
    """

    def linearise(self, step: np.ndarray, *, convex: bool) -> None:
        """Take the derivative of C at ``step``, or of a potential that majorises C's there."""
        ...

    def add_change(self, step: np.ndarray, gradient: Gradient) -> None:
        """Add C(step) (N)."""
        ...

    def add_rate(self, step: np.ndarray, rate: Gradient) -> None:
        """Add the derivative of C along ``step``, at the place where it was taken last; first 0."""
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
            Whether the potential has changed, equal on all ranks.
        """

    @abstractmethod
    def lag_error(self, dofs: np.ndarray) -> float:
        """Relative change of lagged quantities since the last update, equal on all ranks."""

    @abstractmethod
    def lagged_correction(self, dofs: np.ndarray) -> LaggedCorrection | None:
        """Change of the gradient along a step from ``dofs`` due to that of lagged quantities.

        It is None if there are no lagged quantities at present.
        """

    @abstractmethod
    def lagged_state(self) -> Any:
        """The lagged quantities, which a state does not contain."""

    @abstractmethod
    def restore_lagged(self, state: Any) -> None:
        """Set the lagged quantities to what :meth:`lagged_state` gave."""
