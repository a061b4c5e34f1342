"""Inverses of a tangent as preconditioners; MUMPS' factorisation, its order and its workspace."""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.newton.symmetric import symmetric

FIRST_PERCENT: Final = 100
"""Memory beyond MUMPS' estimate (%) with which a factorisation is repeated at first."""

GROWTH: Final = 4
"""Factor on that memory for each further repetition."""

MOST_PERCENT: Final = 400
"""The largest such memory (%); a matrix of zeros needs no more to be refused."""

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


def cheapest(graph: sp.csr_matrix, comm: MPI.Comm, smallest: int = 1000) -> Order:
    """The order of :data:`CANDIDATES` with the fewest operations, equal on all ranks.

    Args:
        graph: (owned nodes, nodes) symmetric; nodes that a matrix couples, each with itself.
        comm: communicator of the ranks that own the nodes.
        smallest: number of nodes below which no order is sought; PORD ends the process on tiny
            graphs.
    """
    if graph.shape[1] < smallest:
        return Order(AUTOMATIC)
    matrix = _laplacian(graph, comm)
    orders = [_tried(matrix, ordering) for ordering in CANDIDATES]
    matrix.destroy()
    return min(orders, key=lambda order: order.operations)


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
    order = Order(
        ordering,
        float(entries if entries >= 0 else -1e6 * entries),
        float(factor.getMumpsRinfog(1)),
    )
    pc.destroy()
    return order


class Inverse(Protocol):
    """A solver with one matrix, exact or approximate, and with matrices near it.

    Attributes:
        exact: whether it is :class:`Exact`.
        pc: applies it to a vector.
        negative: negative eigenvalues of the matrix, or fewer where the inverse is not exact.
        failed: why there is none; 0 if there is one.
    """

    exact: bool
    pc: PETSc.PC

    def set_up(self, matrix: PETSc.Mat) -> None:
        """Take ``matrix`` as the one to invert."""
        ...

    @property
    def negative(self) -> int: ...

    @property
    def failed(self) -> int: ...


class Exact(Inverse, Protocol):
    """An inverse up to rounding, whose ``pc`` may be less exact than its solutions.

    Solutions are those of the matrix that was set up, which must not have changed.
    """

    def solve(self, right: PETSc.Vec, solution: PETSc.Vec, rtol: float) -> None:
        """Solve for one right-hand side to an error of ``rtol`` times the solution."""
        ...

    def solve_many(self, right: np.ndarray) -> np.ndarray:
        """Solutions for (n, k) right-hand sides, this rank's rows, (n, k)."""
        ...


class Factorisation:
    """The inverse of a symmetric matrix by MUMPS' LDLᵀ.

    Args:
        prefix: prefix of PETSc's options.
        comm: ranks.
        order: elimination order; default: MUMPS chooses it.
        counts_pivots: whether all negative pivots must count: the last front is on one rank then.
    """

    exact = True

    def __init__(
        self,
        prefix: str,
        comm: MPI.Comm,
        order: int = AUTOMATIC,
        *,
        counts_pivots: bool = False,
    ) -> None:
        self.pc = PETSc.PC().create(comm)
        self.pc.setOptionsPrefix(prefix)
        self.pc.setType(PETSc.PC.Type.CHOLESKY)
        self.pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        # a run in which nothing moves factorises nothing, and PETSc would tell of these at its end
        PETSc.Options()["options_left"] = False
        options = PETSc.Options(prefix)
        options["mat_mumps_icntl_24"] = 0
        if counts_pivots:
            options["mat_mumps_icntl_13"] = 1
        else:
            options["mat_mumps_icntl_7"] = order

    def set_up(self, matrix: PETSc.Mat) -> None:
        """Factorise ``matrix``."""
        self.pc.setReusePreconditioner(False)
        self.pc.setOperators(matrix)
        factorise_by_mumps(self.pc)
        self.pc.setReusePreconditioner(True)

    @property
    def negative(self) -> int:
        """Negative pivots."""
        return int(self.pc.getFactorMatrix().getMumpsInfog(12))

    @property
    def failed(self) -> int:
        """PETSc's reason why the matrix could not be factorised; 0 if it was."""
        return int(self.pc.getFailedReason())

    def solve(self, right: PETSc.Vec, solution: PETSc.Vec, rtol: float) -> None:
        """Solve for one right-hand side to rounding."""
        self.pc.apply(right, solution)

    def solve_many(self, right: np.ndarray) -> np.ndarray:
        """Solutions for (n, k) right-hand sides, this rank's rows, (n, k).

        MUMPS passes its factors through memory once for a block of them, not once for each.
        """
        factor = self.pc.getFactorMatrix()
        size = (right.shape[0], factor.getSize()[0])
        columns = (PETSc.DECIDE, right.shape[1])
        b, x = (PETSc.Mat().createDense((size, columns), comm=self.pc.comm) for _ in range(2))
        b.setUp()
        b.getDenseArray()[:] = right
        for matrix in (b, x):
            matrix.setUp()
            matrix.assemble()
        factor.matSolve(b, x)
        solutions = x.getDenseArray().copy()
        b.destroy()
        x.destroy()
        return np.asarray(solutions)


RELAXATION: Final = "mat_mumps_icntl_14"
"""PETSc's option for MUMPS' ICNTL(14): by how many per cent the workspace exceeds the estimate."""

TOO_SMALL: Final = (-8, -9, -14, -17, -20)
"""INFOG(1) of MUMPS where the integer or real workspace, or a buffer of messages, is too small."""


def factorise_by_mumps(pc: PETSc.PC) -> None:
    """Factorise; if MUMPS' workspace is too small, factorise again with a larger one.

    The estimate does not know delayed pivots, which saddle points have. Rounding decides which ones
    are delayed, and on several ranks the order in which messages arrive does so, too. A
    body of few elements needs twice the estimate then (MUMPS Users' Guide, error -9).

    Args:
        pc: a factorisation by MUMPS with its operators; what it still fails by is its own
            ``getFailedReason``.
    """
    pc.setUp()
    more = FIRST_PERCENT
    while more <= MOST_PERCENT and pc.getFactorMatrix().getMumpsInfog(1) in TOO_SMALL:
        operators = pc.getOperators()
        pc.reset()  # PETSc takes no further matrix for factors that ran out of memory once
        pc.setOperators(*operators)
        PETSc.Options(pc.getOptionsPrefix())[RELAXATION] = more
        pc.setUp()
        more *= GROWTH
