"""A summand of the total potential."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.model.tangent_state import Carried
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


class Term:
    """A summand of Π, or of the load step's incremental potential.

    A term overrides the methods that it needs; the inherited ones do nothing. All displacements are
    local arrays of degrees of freedom, ghosts included (mm). What only some terms have is told by
    further bases: :class:`~.lagged.Lagged`, :class:`~.memory.Memory` and
    :class:`~.tangent_state.Regularised`.

    Attributes:
        name: by which a step that this term bounds is reported.
        singular_at_rest: its tangent may have no stiffness against some motions until there is some
            strain, so that Newton's first steps may be far too long.
        carried: what its tangent carries along Newton's steps; None where there is nothing.
    """

    name: ClassVar[str] = ""
    singular_at_rest: bool = False
    carried: Carried | None = None

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
