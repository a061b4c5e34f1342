"""Supports: regions that are held, and one whose displacement follows a few global unknowns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.unknowns import NODE, GlobalUnknown, Gradient, Unknowns


def at_rest(
    space: fem.FunctionSpace, domain: Domain, held: Mapping[int, Sequence[str]]
) -> list[fem.DirichletBC]:
    """The conditions that hold regions at rest.

    Args:
        space: of the displacement.
        domain: reference configuration.
        held: regions without displacement along each axis.
    """
    # by component: on a whole blocked space dolfinx 0.9 takes ghosts for owned dofs
    supports = []
    for axis, regions in held.items():
        if not regions:
            continue
        along = space.sub(axis)
        dofs = fem.locate_dofs_topological(along, 2, domain.facets(*regions))
        supports.append(fem.dirichletbc(PETSc.ScalarType(0.0), dofs, along))
    return supports


class SupportMotion(NamedTuple):
    """The motion of a support with one global unknown.

    Attributes:
        unknown: the global unknown.
        mode: returns (3, n) displacements (mm) at (3, n) reference coordinates (mm) for a unit of
            the unknown's value.
    """

    unknown: GlobalUnknown
    mode: Callable[[np.ndarray], np.ndarray]


class MovingSupport:
    """Supported displacements u_S that follow global unknowns a: u_S = Σ a_j W_j.

    Π is a function of the free displacements u_F and of a. Its derivative by a is Wᵀ r_S, where r_S
    is the gradient by the supported displacements, and its second derivatives are K_FS W and
    Wᵀ K_SS W. The supported displacements stay in the vector of unknowns, so that the vector has
    the whole displacement. Their equations are those of ½ |u_S − W a|² · 1 N/mm. This is 0 at
    every solution and after each of Newton's steps, because the constraint is linear. It is not a
    penalty: its size changes nothing.

    Args:
        u: displacement (mm).
        supports: conditions that hold the nodes, along all axes that ``motions`` move them.
        nodes: local displacement nodes of the support, ghosts included.
        motions: motions of the support, at least one.

    Attributes:
        global_unknowns: global unknowns of the motions.
        dofs: this rank's owned displacement dofs that move.
    """

    def __init__(
        self,
        u: fem.Function,
        supports: Sequence[fem.DirichletBC],
        nodes: np.ndarray,
        motions: Sequence[SupportMotion],
    ) -> None:
        space = u.function_space
        self._comm = space.mesh.comm
        self._owned_nodes = space.dofmap.index_map.size_local
        self.global_unknowns = [motion.unknown for motion in motions]
        self.dofs: np.ndarray = np.empty(0, dtype=np.int64)
        self._u, self._nodes, self._motions = u, nodes, motions
        held = np.zeros(len(u.x.array), dtype=bool)
        for bc in supports:
            held[bc.dof_indices()[0]] = True
        self._functions = [fem.Function(space) for _ in motions]
        self.dofs = np.flatnonzero(self.measure().any(axis=0))
        assert held[self._moved].all(), "a support moves along an axis that it does not hold"
        self.measure()

    def measure(self) -> np.ndarray:
        """Compute the motions of the nodes at their present reference places.

        Returns:
            (m, n) motions of this rank's owned displacements.
        """
        points = self._u.function_space.tabulate_dof_coordinates()[self._nodes].T
        for function, motion in zip(self._functions, self._motions, strict=True):
            function.x.array.reshape(-1, NODE)[self._nodes] = motion.mode(points).T
        self._moved = np.any([function.x.array != 0 for function in self._functions], axis=0)
        owned = np.array([f.x.array[: NODE * self._owned_nodes] for f in self._functions])
        self._ways = owned[:, self.dofs]
        return owned

    def place(self) -> None:
        """Set u_S = W a at all local nodes."""
        placed = sum(
            motion.unknown.value * function.x.array
            for motion, function in zip(self._motions, self._functions, strict=True)
        )
        self._u.x.array[self._moved] = placed[self._moved]

    def apart(self, dofs: np.ndarray) -> np.ndarray:
        """u_S − W a (mm) at the owned dofs that move."""
        values = np.array([unknown.value for unknown in self.global_unknowns])
        return np.asarray(dofs[self.dofs] - values @ self._ways)

    # -- the chain rule ----------------------------------------------------------------------------

    def add_gradient(self, dofs: np.ndarray, forces_N: np.ndarray, gradient: Gradient) -> None:
        """Add the slopes by the global unknowns and the equations of the moving displacements.

        Args:
            dofs: displacement.
            forces_N: derivatives of Π by all owned unknowns, supported ones included.
            gradient: gradient that is added to; its rows of supported displacements are 0.
        """
        apart = self.apart(dofs)
        local = self._ways @ (forces_N[self.dofs] - apart)
        slopes = self._comm.allreduce(local, MPI.SUM)
        for unknown, slope in zip(self.global_unknowns, slopes, strict=True):
            gradient.add(unknown, float(slope))
        gradient.array[self.dofs] += apart

    def hessian(
        self, unknowns: Unknowns, free: np.ndarray, product: Callable[[np.ndarray], np.ndarray]
    ) -> sp.csr_matrix:
        """The constraint's part of second derivatives; see :meth:`.Model.constraint_hessian`.

        The diagonal of ½ |u_S − W a|² is 1 N/mm, like that of supports.

        Args:
            unknowns: unknowns of the model.
            free: 1 for owned unknowns that no support holds, else 0.
            product: of the second derivatives of all terms, and an owned array.
        """
        ways = self._ways * [[unknown.scale] for unknown in self.global_unknowns]
        along = np.zeros((len(ways), unknowns.owned_size))
        along[:, self.dofs] = ways
        products = np.array([product(direction) for direction in along])
        within = self._comm.allreduce((products[:, self.dofs] + ways) @ ways.T, MPI.SUM)
        rows = free * products
        rows[:, self.dofs] = -ways
        indices = [unknown.index for unknown in self.global_unknowns]
        border = np.zeros((unknowns.owned_size, unknowns.padded))
        border[:, indices] = rows.T
        if unknowns.owns_globals:
            square = unknowns.global_rows(border)
            square[indices] += unknowns.global_rows(rows.T).T
            square[np.ix_(indices, indices)] += within
        places = sp.csr_matrix(border)
        columns = places.indices + unknowns.size - unknowns.padded
        shape = (unknowns.owned_size, unknowns.size)
        return sp.csr_matrix((places.data, columns, places.indptr), shape)
