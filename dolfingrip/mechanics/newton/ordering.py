"""The elimination order with which a factorisation costs least."""

from __future__ import annotations

from typing import Final

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


def cheapest(graph: sp.csr_matrix, comm: MPI.Comm) -> int:
    """The ICNTL(7) of :data:`CANDIDATES` with the fewest operations, equal on all ranks.

    Args:
        graph: (owned nodes, nodes) symmetric; nodes that a matrix couples, each with itself.
        comm: communicator of the ranks that own the nodes.
    """
    if graph.shape[1] < LINEAR.smallest_graph:
        return AUTOMATIC
    matrix = _laplacian(graph, comm)
    operations = {ordering: _operations(matrix, ordering) for ordering in CANDIDATES}
    matrix.destroy()
    return min(operations, key=operations.__getitem__)


def _laplacian(graph: sp.csr_matrix, comm: MPI.Comm) -> PETSc.Mat:
    """A definite matrix with one unknown for each node, which is cheap to factorise."""
    first = sum(comm.allgather(graph.shape[0])[: comm.rank])
    row, column = graph.nonzero()
    values = np.where(column == row + first, np.diff(graph.indptr)[row] + 1.0, -1.0)
    return symmetric(sp.csr_matrix((values, (row, column)), graph.shape), comm)


def _operations(matrix: PETSc.Mat, ordering: int) -> float:
    """MUMPS' estimate of floating-point operations."""
    pc = PETSc.PC().create(matrix.comm)
    pc.setOperators(matrix)
    pc.setType(PETSc.PC.Type.CHOLESKY)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    pc.setFactorSetUpSolverType()
    factor = pc.getFactorMatrix()
    factor.setMumpsIcntl(7, ordering)
    pc.setUp()
    found = float(factor.getMumpsRinfog(1))
    pc.destroy()
    return found
