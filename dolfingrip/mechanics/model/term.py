"""A summand of the total potential."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.unknowns import NODE, GlobalUnknown, Gradient


class Coupling(NamedTuple):
    """A part of a Hessian that may couple nodes of different elements.

    Attributes:
        nodes: (n,) block numbers in the tangent matrix of nodes, and of global unknowns.
        hessian: (3n, 3n) second derivatives (N/mm). A rank uses the rows of the nodes that it owns,
            so all ranks may give the same matrix, or each rank only its rows.
    """

    nodes: np.ndarray
    hessian: sp.coo_matrix


class NoShapeGradient(Exception):
    """A term or a reading has no assembled derivative by the mesh's coordinates."""


class Term:
    """A summand of the total potential Π, or of the load step's incremental potential.

    A term overrides the methods that it needs; the inherited ones do nothing. All displacements are
    local arrays of degrees of freedom, ghosts included (mm). Some terms have further base classes:
    :class:`Lagged` and :class:`~.state.Memory`.

    Attributes:
        name: name by which a bound of this term on a step is reported.
        singular_at_rest: whether its tangent may have no stiffness against some motions without any
            strain, so that Newton's first steps may be far too long.
        crowded: whether surfaces are pressed on one another over wide areas, so that many pairs
            meet in one step; see :attr:`~.globalisation.Globalisation.convex`.
    """

    name: ClassVar[str] = ""
    singular_at_rest: bool = False
    crowded: bool = False

    # -- the potential ---------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ) of the meshed part, the same on all ranks."""
        return 0.0

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the derivatives by the unknowns at the displacement ``dofs`` to ``gradient``."""

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """Second derivatives in addition to those of :meth:`tangent_forms`.

        Args:
            dofs: displacement.
            convex: whether parts that make a pair's Hessian indefinite are left out.
        """
        return ()

    def move_reference(self, change: np.ndarray | None) -> None:
        """Move the reference nodes by ``change`` (local array, mm); None: put them back."""

    def add_shape_gradient(self, dofs: np.ndarray, gradient: ShapeGradient) -> None:
        """Add the derivatives of the potential by the reference coordinates.

        Raises:
            NoShapeGradient: one line, where the term has none.
        """
        raise NoShapeGradient(f"{self.name or type(self).__name__}: no derivative by coordinates")

    def tangent_forms(self) -> Sequence[Sequence[fem.Form]]:
        """Second derivatives that elements integrate, by blocks of fields; () if there are none."""
        return ()

    def scale_N(self) -> float:
        """Force that the residual's tolerance may refer to; 0 if the term has none."""
        return 0.0

    # -- Newton's steps --------------------------------------------------------------------------

    def set_residual(self, residual_N: float) -> None:
        """Set the residual at which a tangent is assembled; 0 for the exact tangent.

        A term may add a stiffness to its tangent which vanishes with the residual.

        Args:
            residual_N: its norm.
        """

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest admissible fraction of ``step``, in [0, 1], the same on all ranks.

        Args:
            dofs: displacement.
            step: local array of the unknowns, the displacement first.
        """
        return 1.0

    def rejects(self, dofs: np.ndarray) -> str:
        """Why a converged state is not accepted; "" if it is accepted."""
        return ""


def global_coupling(
    global_unknowns: Sequence[GlobalUnknown], first: int, mixed: np.ndarray, within: np.ndarray
) -> Coupling:
    """The coupling of global unknowns with displacements and with one another.

    Args:
        global_unknowns: the m global unknowns.
        first: this rank's first displacement node.
        mixed: (m, 3n) derivatives by each unknown's value and this rank's owned displacements.
        within: (m, m) derivatives by the global unknowns' values, the same on all ranks.
    """
    scales = np.array([unknown.scale for unknown in global_unknowns])
    mixed = mixed * scales[:, None]
    within = within * scales[:, None] * scales
    felt = np.flatnonzero(mixed.reshape(len(global_unknowns), -1, NODE).any(axis=(0, 2)))
    base = min(unknown.node for unknown in global_unknowns)
    blocks = 1 + max(unknown.node for unknown in global_unknowns) - base
    nodes = np.concatenate([first + felt, base + np.arange(blocks)])
    columns = NODE * (len(felt) - base) + np.array(
        [NODE * unknown.node + unknown.component for unknown in global_unknowns]
    )
    values = mixed.reshape(len(global_unknowns), -1, NODE)[:, felt].reshape(
        len(global_unknowns), -1
    )
    which, rows = np.nonzero(values)
    i, j = (part.ravel() for part in np.meshgrid(columns, columns, indexing="ij"))
    data = np.concatenate([values[which, rows], within.ravel()])
    places = (np.concatenate([rows, i]), np.concatenate([columns[which], j]))
    size = NODE * len(nodes)
    return Coupling(nodes, sp.coo_matrix((data, places), shape=(size, size)))


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
