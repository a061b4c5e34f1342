"""The elimination order with which a factorisation costs least."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.newton.policy import LINEAR
from dolfingrip.mechanics.newton.symmetric import symmetric

CANDIDATES: Final = (2, 4, 6)
"""MUMPS' ICNTL(7): approximate minimum fill, PORD, minimum degree with quasi-dense rows. On one
structured mesh the first takes half the operations of the last, on the next three times as many."""

AUTOMATIC: Final = 7
"""MUMPS' ICNTL(7) with which MUMPS itself chooses the order."""


class Order(NamedTuple):
    """An elimination order.

    Attributes:
        number: MUMPS' ICNTL(7).
        entries: of the factors, one for each pair of nodes; 0 if they are few.
        operations: of the factorisation, with one unknown for each node.
    """

    number: int
    entries: float = 0.0
    operations: float = 0.0


def cheapest(graph: sp.csr_matrix, comm: MPI.Comm) -> Order:
    """The order of :data:`CANDIDATES` with the fewest operations, equal on all ranks.

    Args:
        graph: (owned nodes, nodes) symmetric; nodes that a matrix couples, each with itself.
        comm: communicator of the ranks that own the nodes.
    """
    if graph.shape[1] < LINEAR.smallest_graph:
        return Order(AUTOMATIC)
    matrix = _laplacian(graph, comm)
    found = [_tried(matrix, ordering) for ordering in CANDIDATES]
    matrix.destroy()
    return min(found, key=lambda order: order.operations)


def _laplacian(graph: sp.csr_matrix, comm: MPI.Comm) -> PETSc.Mat:
    """A definite matrix with one unknown for each node, which is cheap to factorise."""
    first = sum(comm.allgather(graph.shape[0])[: comm.rank])
    row, column = graph.nonzero()
    values = np.where(column == row + first, np.diff(graph.indptr)[row] + 1.0, -1.0)
    return symmetric(sp.csr_matrix((values, (row, column)), graph.shape), comm)


def _tried(matrix: PETSc.Mat, ordering: int) -> Order:
    """An order with MUMPS' estimates of its cost."""
    pc = PETSc.PC().create(matrix.comm)
    pc.setOperators(matrix)
    pc.setType(PETSc.PC.Type.CHOLESKY)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    pc.setFactorSetUpSolverType()
    factor = pc.getFactorMatrix()
    factor.setMumpsIcntl(7, ordering)
    pc.setUp()
    entries = factor.getMumpsInfog(20)  # in millions where it is negative
    found = Order(
        ordering,
        float(entries if entries >= 0 else -1e6 * entries),
        float(factor.getMumpsRinfog(1)),
    )
    pc.destroy()
    return found
