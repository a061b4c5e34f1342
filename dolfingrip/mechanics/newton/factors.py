"""Linear solves of Newton's method: the factors of one tangent also serve the next ones."""

from __future__ import annotations

from functools import partial

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

from dolfingrip.mechanics.newton import workspace
from dolfingrip.mechanics.newton.counts import Counts
from dolfingrip.mechanics.newton.lagged_correction import CorrectedStep
from dolfingrip.mechanics.newton.ordering import AUTOMATIC, cheapest
from dolfingrip.mechanics.newton.policy import FactorPolicy


class Factors:
    """Solves with the present matrix, using factors of an earlier one as long as these are good.

    Factorising costs about ten times as much as solving. If the matrix has changed a little, GMRES
    (Saad & Schultz, SIAM J. Sci. Stat. Comput. 7, 1986) with the earlier factors as preconditioner
    takes a few iterations. If they cost more than a factorisation, the matrix is factorised. This
    is a preconditioner of PETSc's type ``python``, which is applied once (``preonly``).

    Args:
        prefix: prefix of the factorisation's options.
        graph: (owned nodes, nodes) nodes that the matrix couples at first; the elimination order
            follows from it. None: MUMPS chooses the order.
        policy: how long factors serve.
        counts: counts that solves add to.

    Attributes:
        corrected_step: the operator that the next matrix is a part of; None if it is the whole.
    """

    def __init__(
        self, prefix: str, graph: sp.csr_matrix | None, policy: FactorPolicy, counts: Counts
    ) -> None:
        self._prefix = prefix
        self._policy = policy
        self._counts = counts
        self._graph = graph
        self._ksp: PETSc.KSP | None = None
        self._factorised: PETSc.Mat | None = None
        self._current = False
        self._good = False
        self.corrected_step: CorrectedStep | None = None

    def renew(self) -> None:
        """Have the next matrix factorised, because it will be far from the last one."""
        self._good = False

    # -- preconditioner of PETSc -------------------------------------------------------------------

    def setUp(self, pc: PETSc.PC) -> None:
        """PETSc calls this after the matrix has changed."""
        self._current = False

    def apply(self, pc: PETSc.PC, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """Solve; ``pc`` is marked as failed if the matrix cannot be factorised."""
        matrix = pc.getOperators()[0]
        ksp = self._ksp or self._create(matrix)
        if self.corrected_step is not None:
            self.corrected_step.solve(partial(self._solve_beside, ksp, matrix), right, solution)
            pc.setFailedReason(ksp.getPC().getFailedReason())
            return
        if not self._current:
            if self._good and matrix == self._factorised:
                ksp.setOperators(matrix)
                ksp.solve(right, solution)
                self._good = ksp.getIterationNumber() <= self._policy.worn
                if ksp.getConvergedReason() > 0:
                    return
            self._factorise(ksp, matrix)
        ksp.getPC().apply(right, solution)
        pc.setFailedReason(ksp.getPC().getFailedReason())

    def _solve_beside(
        self,
        ksp: PETSc.KSP,
        matrix: PETSc.Mat,
        operator: PETSc.Mat,
        right: PETSc.Vec,
        solution: PETSc.Vec,
    ) -> None:
        """Solve with an ``operator`` near ``matrix``, by the factors of this or an earlier one."""
        most = (self._policy.operator_iterations, self._policy.operator_iterations_at_most)
        known = self._good and matrix == self._factorised
        for fresh in (False, True) if known else (True,):
            if fresh and not self._current:
                self._factorise(ksp, matrix)
            ksp.setOperators(operator, matrix)
            ksp.setTolerances(rtol=self._policy.operator_rtol, max_it=most[fresh])
            ksp.solve(right, solution)
            done = ksp.getConvergedReason() > 0
            self._good = self._current or ksp.getIterationNumber() <= self._policy.iterations
            ksp.setTolerances(rtol=self._policy.rtol, max_it=self._policy.iterations)
            ksp.setOperators(matrix, matrix)
            if done:
                return
        ksp.getPC().apply(right, solution)

    # -- many right-hand sides ---------------------------------------------------------------------

    def factorise(self, matrix: PETSc.Mat) -> None:
        """Factorise ``matrix``, even if earlier factors are good."""
        self._factorise(self._ksp or self._create(matrix), matrix)

    def solve_many(self, right: np.ndarray) -> np.ndarray:
        """(n, k) solutions for (n, k) right-hand sides, this rank's rows, by the present factors.

        MUMPS passes its factors through memory once for a block of them, not once for each.
        """
        assert self._ksp is not None
        factor = self._ksp.getPC().getFactorMatrix()
        size = (right.shape[0], factor.getSize()[0])
        columns = (PETSc.DECIDE, right.shape[1])
        comm = self._ksp.comm
        b, x = (PETSc.Mat().createDense((size, columns), comm=comm) for _ in range(2))
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

    def _create(self, matrix: PETSc.Mat) -> PETSc.KSP:
        self._ksp = ksp = PETSc.KSP().create(matrix.comm)
        ksp.setOptionsPrefix(self._prefix)
        ksp.setType(PETSc.KSP.Type.GMRES)
        ksp.setPCSide(PETSc.PC.Side.LEFT)  # its residual is nearly the error of the displacement
        ksp.setTolerances(rtol=self._policy.rtol, max_it=self._policy.iterations)
        pc = ksp.getPC()
        pc.setType(PETSc.PC.Type.CHOLESKY)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        options = PETSc.Options(self._prefix)
        options["mat_mumps_icntl_24"] = 0
        order = AUTOMATIC if self._graph is None else cheapest(self._graph, matrix.comm.tompi4py())
        options["mat_mumps_icntl_7"] = order
        return ksp

    def _factorise(self, ksp: PETSc.KSP, matrix: PETSc.Mat) -> None:
        pc = ksp.getPC()
        pc.setReusePreconditioner(False)
        pc.setOperators(matrix)
        workspace.set_up(pc)
        pc.setReusePreconditioner(True)
        self._factorised = matrix
        self._current = self._good = True
        self._counts.factorisations += 1
