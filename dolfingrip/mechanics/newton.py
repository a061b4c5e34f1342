"""Newton's method: PETSc SNES with a direct symmetric factorisation."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.config import Solver
from dolfingrip.mechanics.model import Model
from dolfingrip.mechanics.profile import Profile
from dolfingrip.mechanics.tangent import Tangent

CHORD = 0.02
"""An iteration that brought the residual below this part of the one before leaves a tangent
good enough for the next iteration, too; factorising it is what costs."""

STUBBORN = 0.7
"""Once the first iterations are over, a residual that falls by less calls a line search."""

SETTLED = 2
"""Iterations after which a step that a bound cuts is searched: a new touch must not undo them."""

HOPELESS = 3.0
"""A residual so many times its early peak does not come back."""

EARLY = 4
"""Iterations in which the residual may rise, as the carried stress makes it do."""

SHORTEST_STEP = 1e-3
"""A Newton step shortened below this fraction makes no progress any more."""


class Ending(StrEnum):
    """How a solve ended."""

    CONVERGED = "converged"
    ITERATIONS = "iteration limit"
    DIVERGED = "diverged"
    INVERTED = "inverted"
    BLOCKED = "blocked by contact"
    SINGULAR = "singular tangent"


@dataclass(frozen=True, slots=True)
class Solve:
    """Outcome of one solve.

    Attributes:
        ending: converged, or why not.
        iterations: Newton iterations taken.
        residual_N: norm of the last residual.
        negative_pivots: of the last factorisation; more than 0 where Π is no minimum.
    """

    ending: Ending
    iterations: int
    residual_N: float
    negative_pivots: int

    @property
    def converged(self) -> bool:
        """Whether the residual met its tolerance."""
        return self.ending is Ending.CONVERGED


class Newton:
    """Finds a stationary point of a model's Π from its present state.

    Globalisation is the model's bound on a step (contact, inversion). Within it full steps are
    taken at first, since the carried stress makes the residual rise before it falls; later a
    residual that stagnates (pairs of contact that change from step to step) is searched along
    the step, and one that exceeds its early peak ends the solve.

    Attributes:
        iterations: Newton iterations since the start, failed solves included.
        factorisations: of the tangent; fewer, as a good tangent serves twice.
    """

    def __init__(self, model: Model, settings: Solver, profile: Profile | None = None) -> None:
        self.model = model
        self.settings = settings
        self.profile = profile or Profile()
        self.tangent = Tangent(model)
        self._residual = fem_petsc.create_vector(model.potential.residual)
        # never hand u's own vector to SNES: it is copied in and out (FEniCS/dolfinx#3507)
        self._x = self._residual.duplicate()
        self._trial = self._residual.duplicate()
        self._owned = self._x.getLocalSize()
        self._retired: list[PETSc.Mat] = []
        self._snes = self._make_snes()
        self._bound = ""
        self._short = 0
        self._scale = 0.0
        self.iterations = 0
        self.factorisations = 0
        self._keep_factors = False
        self._settled = False
        self._stagnates = False
        self._last_norm = 0.0
        self._peak = 0.0
        self._step = np.zeros_like(model.u.x.array)

    def _make_snes(self) -> PETSc.SNES:
        snes = PETSc.SNES().create(self.model.comm)
        snes.setOptionsPrefix("dolfingrip_")
        snes.setType(PETSc.SNES.Type.NEWTONLS)
        snes.setFunction(self._form_residual, self._residual)
        snes.setJacobian(self._form_tangent, self.tangent.matrix)
        snes.setTolerances(max_it=self.settings.max_iterations)
        snes.setConvergenceTest(self._converged)
        snes.setLineSearchPreCheck(self._bound_step)
        ksp = snes.getKSP()
        ksp.setType(PETSc.KSP.Type.PREONLY)
        pc = ksp.getPC()
        pc.setType(PETSc.PC.Type.CHOLESKY)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        options = PETSc.Options("dolfingrip_")
        options["snes_linesearch_type"] = "basic"
        # a rising residual is no failure here: see the class
        options["snes_divergence_tolerance"] = -1
        options["mat_mumps_icntl_13"] = 1  # counts negative pivots in parallel, too
        options["mat_mumps_icntl_24"] = 0
        snes.setFromOptions()
        return snes

    # -- callbacks -----------------------------------------------------------------------------

    def _take(self, x: PETSc.Vec) -> None:
        """Copy SNES' iterate into the displacement, ghosts included."""
        u = self.model.u.x
        u.array[: self._owned] = x.array_r
        u.scatter_forward()

    def _form_residual(self, _snes: Any, x: PETSc.Vec, residual: PETSc.Vec) -> None:
        with self.profile.phase("residual"):
            self._take(x)
            self.model.assemble_residual(residual)

    def _form_tangent(self, snes: PETSc.SNES, x: PETSc.Vec, *_matrices: Any) -> None:
        if self._keep_factors:
            return
        with self.profile.phase("tangent"):
            self.factorisations += 1
            self._take(x)
            before = self.tangent.matrix
            self.tangent.assemble()
            if self.tangent.matrix is not before:
                self._retired.append(before)  # SNES still holds it until this call returns
                snes.setJacobian(self._form_tangent, self.tangent.matrix)

    def _bound_step(self, x: PETSc.Vec, y: PETSc.Vec) -> bool:
        """Shorten SNES' step (x − y) to what is admissible; let the carried stress follow."""
        with self.profile.phase("step bound"):
            self._take(x)
            step = self._step
            step[: self._owned] = -y.array_r
            self._forward(step)
            fraction, self._bound = self.model.admissible_step(step)
            if self._stagnates or (self._bound and self._settled):
                fraction = self._search(step, fraction)
            self._short = self._short + 1 if fraction < SHORTEST_STEP else 0
            step *= fraction
            if self.model.potential.carried is not None:
                self.model.potential.carried.follow(step)
            if fraction < 1.0:
                y.scale(fraction)
        return fraction < 1.0

    def _search(self, step: np.ndarray, longest: float) -> float:
        """The fraction of ``step`` with the smallest residual among the longest and its halves."""
        start = self.model.u.x.array.copy()
        best = (np.inf, longest)
        for fraction in longest * 0.5 ** np.arange(4):
            self.model.u.x.array[:] = start + fraction * step
            self.model.assemble_residual(self._trial)
            best = min(best, (self._trial.norm(), float(fraction)))
        self.model.u.x.array[:] = start
        return best[1]

    def _forward(self, local: np.ndarray) -> None:
        """Fill the ghosts of a local dof array from their owners."""
        holder = self.model.u.x
        kept = holder.array.copy()
        holder.array[:] = local
        holder.scatter_forward()
        local[:] = holder.array
        holder.array[:] = kept

    def _converged(
        self, _snes: Any, iteration: int, norms: tuple[float, float, float], *_: Any
    ) -> int:
        norm = norms[2]
        reason = PETSc.SNES.ConvergedReason
        if not np.isfinite(norm):
            return reason.DIVERGED_FNORM_NAN
        if iteration == 0:
            self._scale = norm
        if iteration <= EARLY:
            self._peak = max(self._peak, norm)
        if self._short > 2:
            return reason.DIVERGED_LINE_SEARCH
        tolerance = max(self.settings.atol_N, self.settings.rtol * self._scale)
        if norm <= tolerance and not self._bound:
            return reason.CONVERGED_FNORM_RELATIVE
        self._keep_factors = norm < CHORD * self._last_norm and not self._bound
        self._settled = iteration >= SETTLED
        self._stagnates = iteration > EARLY and norm > STUBBORN * self._last_norm
        self._last_norm = norm
        if iteration > EARLY and norm > HOPELESS * self._peak:
            return reason.DIVERGED_DTOL
        return reason.CONVERGED_ITERATING

    # -- solve ---------------------------------------------------------------------------------

    def solve(self) -> Solve:
        """Iterate from the model's present state; the state is changed even if this fails."""
        model = self.model
        self._bound, self._short = "", 0
        self._keep_factors, self._stagnates = False, False
        self._last_norm, self._peak = 0.0, 0.0
        if model.potential.carried is not None:
            model.potential.carried.reset()
        self._x.array[:] = model.u.x.array[: self._owned]
        with self.profile.phase("linear solve"):
            self._snes.solve(None, self._x)
        self._take(self._x)
        self._retired.clear()
        iterations = self._snes.getIterationNumber()
        self.iterations += iterations
        return Solve(
            self._ending(self._snes.getConvergedReason()),
            iterations,
            float(self._snes.getFunctionNorm()),
            self.negative_pivots() if iterations else 0,
        )

    def negative_pivots(self) -> int:
        """Negative pivots of the last factorisation (its inertia)."""
        factor = self._snes.getKSP().getPC().getFactorMatrix()
        return int(self.model.comm.allreduce(factor.getMumpsInfog(12), MPI.MAX))

    def _ending(self, reason: int) -> Ending:
        reasons = PETSc.SNES.ConvergedReason
        if reason > 0:
            return Ending.CONVERGED
        if self._short:
            return Ending.INVERTED if self._bound == "inverted" else Ending.BLOCKED
        if reason == reasons.DIVERGED_MAX_IT:
            return Ending.ITERATIONS
        if reason == reasons.DIVERGED_LINEAR_SOLVE:
            return Ending.SINGULAR
        return Ending.DIVERGED
