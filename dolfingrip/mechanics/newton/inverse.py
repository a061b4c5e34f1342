"""Exact and approximate inverses of a tangent, as preconditioners."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.newton import workspace
from dolfingrip.mechanics.newton.ordering import AUTOMATIC


class Inverse(Protocol):
    """What solves with one matrix, exactly or nearly, and with matrices near it.

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
        """(n, k) solutions for (n, k) right-hand sides, this rank's rows."""
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
        workspace.set_up(self.pc)
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
        """(n, k) solutions for (n, k) right-hand sides, this rank's rows.

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
        found = x.getDenseArray().copy()
        b.destroy()
        x.destroy()
        return np.asarray(found)
