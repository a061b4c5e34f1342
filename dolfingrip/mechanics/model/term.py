"""A summand of the total potential, and what it may remember."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.model.unknowns import NODE, GlobalUnknown, Gradient


class Coupling(NamedTuple):
    """Part of a Hessian that couples nodes which no element need join.

    Attributes:
        nodes: (n,) block numbers in the tangent matrix of nodes, and of global unknowns.
        hessian: (3n, 3n) second derivatives (N/mm). A rank takes the rows of the nodes it owns,
            so that all ranks may give the same whole, or each rank its rows alone.
    """

    nodes: np.ndarray
    hessian: sp.coo_matrix


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


class Term:
    """A summand of Π, or of the load step's incremental potential.

    A term overrides the methods that it needs; the inherited ones do nothing. All displacements are
    local arrays of degrees of freedom, ghosts included (mm).

    Attributes:
        name: by which a step that this term bounds is reported.
    """

    name: ClassVar[str] = ""

    # -- the potential ---------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ) of the meshed part, the same on all ranks."""
        return 0.0

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the derivatives by the unknowns at the displacement ``dofs`` to ``gradient``."""

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """Second derivatives beside those of :meth:`tangent_forms`.

        Args:
            dofs: displacement.
            convex: leave out what makes a pair's Hessian indefinite.
        """
        return ()

    def add_gradient_rate(self, dofs: np.ndarray, velocity: np.ndarray, rate: Gradient) -> None:
        """Add the gradient's change as reference points move and displacements do not.

        Args:
            dofs: displacement.
            velocity: of the displacement's nodes (mm for each unit of a parameter).
            rate: N for each unit of the parameter.
        """

    def move_reference(self, change: np.ndarray | None) -> None:
        """Move the reference nodes by ``change`` (local array, mm); None: put them back."""

    def add_constant_rate(self, dofs: np.ndarray, constant: fem.Constant, rate: Gradient) -> None:
        """Add the derivative of the gradient by a constant that this term, not the forms, has.

        Args:
            dofs: displacement.
            constant: of any term.
            rate: N for each unit of the constant.
        """

    def tangent_forms(self) -> Sequence[Sequence[fem.Form]]:
        """Second derivatives that elements integrate, by blocks of fields; () where none."""
        return ()

    def scale_N(self) -> float:
        """Force that the residual's tolerance may refer to; 0 where the term has none."""
        return 0.0

    def set_residual(self, residual_N: float) -> None:
        """Take note of the residual at which Newton's method asks for a tangent; 0 for the exact.

        A term may stiffen its part of the tangent by as much as vanishes with the residual.
        """

    # -- Newton's steps --------------------------------------------------------------------------

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest admissible fraction of ``step``, in [0, 1], the same on all ranks.

        Args:
            dofs: displacement.
            step: local array of the unknowns, the displacement first.
        """
        return 1.0

    def rejects(self, dofs: np.ndarray) -> str:
        """Why a converged state is not accepted; "" where it is."""
        return ""

    # -- quantities that lag behind a minimisation -------------------------------------------------

    def update_lagged(self, dofs: np.ndarray) -> bool:
        """Update, from the displacement ``dofs``, what the potential keeps fixed.

        Newton's method asks for it in its first iterations.

        Returns:
            Whether the potential has changed, the same on all ranks.
        """
        return False

    def lag_error(self, dofs: np.ndarray) -> float:
        """Relative change of lagged quantities since the last update, the same on all ranks."""
        return 0.0

    def lagged_correction(self, dofs: np.ndarray) -> LaggedCorrection | None:
        """How the gradient changes along a step from ``dofs`` by the change of lagged quantities.

        None where there are none.
        """
        return None

    def lagged_state(self) -> Any:
        """Lagged quantities, which a state does not contain; None where there are none."""
        return None

    def restore_lagged(self, state: Any) -> None:
        """Set the lagged quantities to what :meth:`lagged_state` gave."""

    # -- memory ----------------------------------------------------------------------------------

    def follow(self, time_s: float, step_s: float) -> None:
        """Take note of the time at the load step's end and of the step's length (s)."""

    def accept(self) -> None:
        """Take the present, converged state as the start of the next load step."""

    def values(self) -> dict[str, np.ndarray]:
        """Copies of what is remembered, by name."""
        return {}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Remember what :meth:`values` gave."""


def global_coupling(
    global_unknowns: Sequence[GlobalUnknown], first: int, mixed: np.ndarray, within: np.ndarray
) -> Coupling:
    """The coupling of global unknowns with displacements and with one another.

    Args:
        global_unknowns: m of them.
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
