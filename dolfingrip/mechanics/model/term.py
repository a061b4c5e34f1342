"""A summand of the total potential."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.tangent_state import Carried
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
    :class:`~.lagged.Lagged`, :class:`~.memory.Memory` and
    :class:`~.tangent_state.Regularised`.

    Attributes:
        name: name by which a bound of this term on a step is reported.
        singular_at_rest: whether its tangent may have no stiffness against some motions without any
            strain, so that Newton's first steps may be far too long.
        carried: fields that its tangent carries along Newton's steps; None if there are none.
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
        """Second derivatives in addition to those of :meth:`tangent_forms`.

        Args:
            dofs: displacement.
            convex: whether parts that make a pair's Hessian indefinite are left out.
        """
        return ()

    def move_reference(self, change: np.ndarray | None) -> None:
        """Move the reference nodes by ``change`` (local array, mm); None: put them back."""

    def add_shape_gradient(self, dofs: np.ndarray, found: ShapeGradient) -> None:
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
