"""Multigrid of two levels: the quadratic element, and the linear one with a factorisation."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.bordered import factors
from dolfingrip.mechanics.newton.callbacks import preconditioner
from dolfingrip.mechanics.newton.inverse import Exact, cheapest
from dolfingrip.mechanics.newton.linear_level import BLOCK, LinearLevel
from dolfingrip.mechanics.newton.policy import MultigridPolicy


class Multigrid:
    """An approximate inverse of the tangent of a quadratic element: one V-cycle (p-multigrid).

    Chebyshev's iteration on the blocks of the diagonal smooths (Adams, Brezina, Hu & Tuminaro, J.
    Comput. Phys. 188, 2003). The linear level is factorised. It has an eighth of a tetrahedral
    mesh's unknowns and a fourth of a hexahedral one's. Global unknowns are left to the linear
    level.

    Args:
        prefix: prefix of PETSc's options of the factorisation.
        model: model with a displacement of second order, its only field.
        policy: numbers of the smoother.

    Attributes:
        pc: the preconditioner.
    """

    exact = False

    def __init__(
        self, prefix: str, model: Model, policy: MultigridPolicy = MultigridPolicy()
    ) -> None:
        self._policy = policy
        self._level = LinearLevel(model)
        self._model, self._comm = model, model.comm
        self._coarse: Exact | None = None
        self._prefix = prefix + "linear_"
        self._largest = 0.0
        self._vectors: list[PETSc.Vec] = []
        self.pc = preconditioner(model.comm, self.apply)

    def set_up(self, matrix: PETSc.Mat) -> None:
        """Take ``matrix`` as the one to invert."""
        self._matrix = matrix
        coarse, diagonal = self._level.assemble(matrix)
        if self._coarse is None:
            order = cheapest(self._level.graph, self._comm).number
            self._coarse = factors(self._prefix, self._model, order, np.float64)
        self._coarse.set_up(coarse)
        self._invert(diagonal)
        if not self._vectors:
            self._vectors = [matrix.createVecLeft() for _ in range(4)]
            self._below = [coarse.createVecLeft() for _ in range(2)]
        self._largest = self._power()
        self.pc.setOperators(matrix)

    @property
    def negative(self) -> int:
        """Negative eigenvalues on the linear level: the tangent has as many or more."""
        assert self._coarse is not None
        return self._coarse.negative

    @property
    def failed(self) -> PETSc.PC.FailedReason:
        """Why the linear level could not be factorised; 0 if it was."""
        assert self._coarse is not None
        return self._coarse.failed

    # -- preconditioner of PETSc -------------------------------------------------------------------

    def apply(self, pc: PETSc.PC, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """One symmetric V-cycle."""
        assert self._coarse is not None
        residual, low, high = self._vectors[0], *self._below
        solution.set(0.0)
        self._smooth(right, solution, start=False)
        self._matrix.mult(solution, residual)
        residual.aypx(-1.0, right)
        self._level.interpolation.multTranspose(residual, low)
        self._coarse.pc.apply(low, high)
        self._level.interpolation.multAdd(high, solution, solution)
        self._smooth(right, solution, start=True)

    # -- smoother ----------------------------------------------------------------------------------

    def _smooth(self, right: PETSc.Vec, solution: PETSc.Vec, *, start: bool) -> None:
        """Improve ``solution``, which is zero unless ``start``."""
        residual, step, scaled, product = self._vectors
        highest = self._policy.beyond * self._largest
        lowest = highest / self._policy.ratio
        middle, half = (highest + lowest) / 2, (highest - lowest) / 2
        sigma = middle / half
        rho = 1 / sigma
        if start:
            self._matrix.mult(solution, residual)
            residual.aypx(-1.0, right)
        else:
            right.copy(residual)
        self._inverse.mult(residual, step)
        step.scale(1 / middle)
        solution.axpy(1.0, step)
        for _ in range(self._policy.degree - 1):
            self._matrix.mult(step, product)
            residual.axpy(-1.0, product)
            self._inverse.mult(residual, scaled)
            after = 1 / (2 * sigma - rho)
            step.axpby(2 * after / half, after * rho, scaled)
            rho = after
            solution.axpy(1.0, step)

    def _invert(self, diagonal: np.ndarray) -> None:
        """Keep the inverse blocks on the diagonal; 0 for global unknowns."""
        inverse = np.zeros_like(diagonal)
        inverse[self._level.nodes] = np.linalg.inv(diagonal[self._level.nodes])
        count = len(diagonal)
        if self._largest == 0.0:
            size = (BLOCK * count, None)
            self._inverse = PETSc.Mat().createBAIJ((size, size), BLOCK, nnz=(1, 0), comm=self._comm)
        first = self._inverse.getOwnershipRange()[0] // BLOCK
        self._inverse.setValuesBlockedCSR(
            np.arange(count + 1, dtype=PETSc.IntType),
            np.arange(first, first + count, dtype=PETSc.IntType),
            inverse,
        )
        self._inverse.assemble()

    def _power(self) -> float:
        """Largest eigenvalue of D⁻¹K, by the power method, from the last one's vector on."""
        product, step, scaled, _ = self._vectors
        if self._largest == 0.0:
            self._mode = self._matrix.createVecLeft()
            self._mode.array[:] = np.random.default_rng(self._comm.rank).uniform(
                -1, 1, self._mode.local_size
            )
            self._inverse.mult(self._mode, step)  # nothing in global unknowns
            step.copy(self._mode)
        found = 0.0
        for _ in range(self._policy.powers):
            self._mode.normalize()
            self._matrix.mult(self._mode, product)
            self._inverse.mult(product, scaled)
            found = scaled.norm()
            scaled.copy(self._mode)
        return float(found)
