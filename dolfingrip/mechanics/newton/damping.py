"""Newton's linear solves with a tangent that may be indefinite: a motion in a viscous medium."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Final

import ufl
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model.assembly import to_assemble
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.ending import Counts
from dolfingrip.mechanics.newton.inverse import Inverse
from dolfingrip.mechanics.newton.tangent import Tangent

LEAST_DAMPING: Final = 1e-7
"""Smallest damping above 0, relative to the tangent's diagonal."""

STIFFER: Final = 8.0
"""Factor on a damping that leaves the tangent indefinite."""

MOST_OFTEN: Final = 20
"""Largest number of such factors in a row; the last damping is far stiffer than the body."""

EASY: Final = 0.5
LESS: Final = 4.0
"""A step of which a larger part is taken has the next ones damped less, by this factor."""

HARD: Final = 0.1
STRONGER: Final = 4.0
"""A step of which a smaller part is taken has the next ones damped more, by this factor."""

STUCK: Final = 1e-3
FAR_STRONGER: Final = 100.0
"""A step of which a still smaller part is taken has the next ones damped far more, by so much."""

ITERATIONS: Final = 3
"""Factor on the iterations that a solve may take."""

RTOL: Final = 1e-4
"""Preconditioned residual of conjugate gradients, relative to its first."""

SOLVES: Final = 200
"""Largest number of their iterations."""

NEGATIVE = (
    PETSc.KSP.ConvergedReason.DIVERGED_INDEFINITE_MAT,
    PETSc.KSP.ConvergedReason.DIVERGED_INDEFINITE_PC,
)
"""Why conjugate gradients end at a negative curvature."""


class Damping:
    """Factors of K + cM with the smallest damping c that gives the inertia of a minimum.

    The steps are those of a massless body in a viscous medium by the implicit Euler
    method with steps of 1/c in time (pseudo-transient continuation; Kelley & Keyes, SIAM J. Numer.
    Anal. 35, 1998). Where equilibrium ends they reach another stable one, like a finger that snaps
    through. Each step is a descent direction because K + cM has the inertia of a minimum's tangent
    (Wächter & Biegler, Math. Program. 106, 2006). M is the diagonal of the mass matrix at unit
    density. This is a preconditioner of PETSc's type ``python``, which is applied once
    (``preonly``); it adds cM to its matrix.

    Args:
        inverse: inverse of the damped tangent; it tells its inertia.
        model: model whose tangent is factorised.
        tangent: the tangent.
        counts: counts that solves add to.

    Attributes:
        unstable: whether the tangent was indefinite since :meth:`start`.
    """

    def __init__(
        self, inverse: Callable[[], Inverse], model: Model, tangent: Tangent, counts: Counts
    ) -> None:
        self._model = model
        self._counts = counts
        self._tangent = tangent
        # Π is concave in further fields, such as a pressure, and in multipliers
        self._negative = sum(unknown.multiplier for unknown in model.unknowns.global_unknowns)
        for further in model.unknowns.fields[1:]:
            dofmap = further.function_space.dofmap
            self._negative += dofmap.index_map_bs * dofmap.index_map.size_global
        self._create = inverse
        self._least = 0.0
        self.start()

    def start(self) -> None:
        """Forget the last solve."""
        self._damping = 0.0
        self.unstable = False

    def adapt(self, fraction: float) -> None:
        """Damp the next step less or more, depending on the fraction taken of the last step."""
        if abs(fraction) > EASY:
            self._damping /= LESS
            if self._damping < self._least:
                self._damping = 0.0
        elif abs(fraction) < HARD:
            stuck = abs(fraction) <= STUCK
            by = FAR_STRONGER if stuck else STRONGER
            self._damping = max(by * self._damping, self._least)

    # -- preconditioner of PETSc -------------------------------------------------------------------

    def setUp(self, pc: PETSc.PC) -> None:
        """Factorise the matrix, damped."""
        matrix = pc.getOperators()[0]
        stiffness = matrix.getDiagonal().norm(PETSc.NormType.N1)
        self._least = LEAST_DAMPING * stiffness / self._masses.norm(PETSc.NormType.N1)
        self._add(matrix, self._damping)
        if self._leads_downhill(matrix):
            return
        # contact of edges that pass one another is far from convex: damping it would hold all
        self._tangent.assemble(convex=True)
        self._add(matrix, self._damping)
        for _ in range(MOST_OFTEN):
            if self._leads_downhill(matrix):
                return
            self._damp_more(matrix)

    def _damp_more(self, matrix: PETSc.Mat) -> None:
        more = max(STIFFER * self._damping, self._least)
        self._add(matrix, more - self._damping)
        self._damping = more

    def _leads_downhill(self, matrix: PETSc.Mat) -> bool:
        """Factorise; return whether the inertia is that of a minimum's tangent."""
        self._inverse.set_up(matrix)
        self._counts.factorisations += 1
        downhill = self._inverse.negative == self._negative
        self.unstable |= not downhill
        return bool(downhill)

    def apply(self, pc: PETSc.PC, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """Solve; ``pc`` is marked as failed if the matrix cannot be factorised."""
        if self._inverse.exact:
            self._inverse.pc.apply(right, solution)
        else:
            self._iterate(pc.getOperators()[0], right, solution)
        pc.setFailedReason(self._inverse.failed)

    def _iterate(self, matrix: PETSc.Mat, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """Solve by conjugate gradients, and damp more where these find a negative curvature.

        An inverse that is not exact may not see each negative eigenvalue.
        """
        for _ in range(MOST_OFTEN):
            self._ksp.setOperators(matrix)
            self._ksp.solve(right, solution)
            if self._ksp.getConvergedReason() not in NEGATIVE:
                return
            self.unstable = True
            self._damp_more(matrix)
            self._leads_downhill(matrix)

    @cached_property
    def _inverse(self) -> Inverse:
        return self._create()

    @cached_property
    def _ksp(self) -> PETSc.KSP:
        ksp = PETSc.KSP().create(self._model.comm)
        ksp.setType(PETSc.KSP.Type.CG)
        ksp.setNormType(PETSc.KSP.NormType.PRECONDITIONED)
        ksp.setPC(self._inverse.pc)
        ksp.setTolerances(rtol=RTOL, max_it=SOLVES)
        return ksp

    def _add(self, matrix: PETSc.Mat, damping: float) -> None:
        if damping > 0:
            matrix.setDiagonal(damping * self._masses, addv=True)

    @cached_property
    def _masses(self) -> PETSc.Vec:
        """Diagonal of the displacement's mass matrix (mm³); a global unknown's is the whole volume.

        Pressures and multipliers have none.
        """
        model = self._model
        space = model.u.function_space
        u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
        matrix = fem_petsc.assemble_matrix(to_assemble(ufl.inner(u, v) * ufl.dx(space.mesh)))
        matrix.assemble()
        diagonal = matrix.getDiagonal().array_r
        masses = model.unknowns.create_vector()
        masses.set(0.0)
        masses.array[: len(diagonal)] = diagonal
        masses.array[model.dependent_dofs] = 0.0  # they follow global unknowns at once
        volume = float(model.comm.allreduce(diagonal.sum(), MPI.SUM)) / 3
        rows = model.unknowns.global_rows(masses.array)
        for unknown in model.unknowns.global_unknowns if len(rows) else ():
            rows[unknown.index] = 0.0 if unknown.multiplier else volume
        return masses
