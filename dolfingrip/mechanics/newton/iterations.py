"""Newton's iterations from one start: the calls of PETSc's SNES, and what one tells the next."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import Guess
from dolfingrip.mechanics.newton.damping import Damping
from dolfingrip.mechanics.newton.ending import Counts, Watch, is_late
from dolfingrip.mechanics.newton.factors import Factors
from dolfingrip.mechanics.newton.globalisation import Globalisation, IterationVerdict
from dolfingrip.mechanics.newton.lagging import CorrectedStep, LagRules
from dolfingrip.mechanics.newton.linear_solver import LinearSolver
from dolfingrip.mechanics.newton.mixed_tangent import MixedTangent, condensing_step
from dolfingrip.mechanics.newton.policy import NewtonPolicy
from dolfingrip.mechanics.newton.tangent import Tangent
from dolfingrip.sections.numerics import Solver

PREFIX = "dolfingrip_"
"""Prefix of PETSc's options."""


class System:
    """The equations of a model with what solves them linearly; nothing in it refers to a SNES.

    Args:
        model: model whose unknowns are solved for.
        settings: tolerances and limits.
        profile: takes the time of each phase.
        policy: numbers behind decisions.
        counts: counts to add to.

    Attributes:
        tangent: the model's tangent.
        linear_solver: makes the inverses of tangents.
        factors: solve with the tangent.
        damping: solves with the tangent of damped steps.
        residual: SNES' vector of the residual.
        watch: tells how a long solve goes on.
    """

    def __init__(
        self, model: Model, settings: Solver, profile: Profile, policy: NewtonPolicy, counts: Counts
    ) -> None:
        model.potential.compile()
        self.model, self.settings, self.policy = model, settings, policy
        self.profile, self.counts, self.watch = profile, counts, Watch()
        mixed = len(model.unknowns.fields) > 1
        self.tangent = MixedTangent(model) if mixed else Tangent(model)
        self.linear_solver = linear = LinearSolver(model, self.tangent, settings)
        self.factors = Factors(
            PREFIX,
            linear.inverse(PREFIX),
            policy.multigrid if linear.iterative else policy.factors,
            counts,
            spare=lambda: linear.factors(PREFIX + "spare_"),
            spare_policy=policy.factors,
        )
        self.damping = Damping(
            lambda: linear.with_inertia(PREFIX + "damped_"), model, self.tangent, counts
        )
        self.residual, self._vector = (model.unknowns.create_vector() for _ in range(2))

    def set_state(self, x: PETSc.Vec) -> None:
        """Copy SNES' iterate into the unknowns and their ghosts."""
        self.model.unknowns.set_owned(x.array_r)

    def norm(self) -> float:
        """Norm of the residual (N) at the present state."""
        self.model.assemble_equations(self._vector)
        return float(self._vector.norm())

    def along(self, step: np.ndarray) -> float:
        """Product of the residual at the present state with a local array of the unknowns."""
        self.model.assemble_equations(self._vector)
        local = self._vector.array_r @ self.model.unknowns.owned_part(step)
        return float(self.model.comm.allreduce(local, MPI.SUM))


class Iterations:
    """Newton's iterations from one start, called by SNES, whose linear solves it also makes.

    It refers to a system and not to the solver, which owns the SNES. So what SNES holds does not
    hold the SNES.

    Args:
        system: equations, and what solves them linearly.
        guess: another start than the model's present state; the tolerance still refers to the
            present state's residual.
        damped: whether each step is damped and searched along.
        corrected: whether lagged quantities may change along steps.
        before: controls of the present state, at which the first tangent is assembled.
        end_s: time on the monotonic clock after which no further iteration begins.

    Attributes:
        rules: lengths of steps, and when to stop.
        lagging: when lagged quantities are updated.
        late: whether the time was over.
    """

    def __init__(
        self,
        system: System,
        guess: Guess | None,
        *,
        damped: bool,
        corrected: bool,
        before: Mapping[str, float],
        end_s: float,
    ) -> None:
        self._end_s, self.late = end_s, False
        self._system = system
        self._model = model = system.model
        self._damped = damped
        self._correction: CorrectedStep | None = None
        self._last_fall = np.inf
        self._retired: list[PETSc.Mat] = []
        system.damping.start()
        scale_N, predicted = self._begin(guess)
        self._before = {} if predicted else before
        # factors of a saddle point cost 17 of GMRES' iterations, so an earlier tangent's are tried
        mixed = len(model.unknowns.fields) > 1
        self.rules = Globalisation(
            model,
            system.settings,
            system.along,
            system.policy.steps,
            scale_N=scale_N,
            elsewhere=guess is not None and not mixed,
            damped=damped,
        )
        self.lagging = LagRules(model, system.policy.lag, predicted=predicted, corrected=corrected)

    def _begin(self, guess: Guess | None) -> tuple[float | None, bool]:
        """Set the state to start from.

        Returns:
            The residual (N) of the model's present state if there is a guess, and whether the
            guess is taken.
        """
        model, system = self._model, self._system
        if guess is None:
            model.carried.reset()
            return None, False
        most = self._system.policy.guess_residual_ratio
        first_N, here = system.norm(), model.unknowns.local()
        model.unknowns.set_local(guess.unknowns)
        model.carried.values = guess.carried
        if most < np.inf and system.norm() > most * first_N:
            model.unknowns.set_local(here)
            model.carried.reset()
            return first_N, False
        return first_N, True

    def run(self, snes: PETSc.SNES, x: PETSc.Vec) -> None:
        """Iterate from the model's state to the end, which is then the model's state.

        Args:
            snes: calls this object until its next solve.
            x: vector of the iterates.
        """
        snes.setFunction(self._form_residual, self._system.residual)
        snes.setJacobian(self._form_tangent, self._system.tangent.matrix)
        snes.setConvergenceTest(self._converged)
        snes.setLineSearchPreCheck(self._bound_step)
        snes.getKSP().getPC().setPythonContext(self)
        x.array[:] = self._model.unknowns.owned()
        with self._system.profile.phase("linear solve"):
            raised: BaseException | None = None  # by a callback
            try:
                snes.solve(None, x)
            except PETSc.Error as error:
                raised = error.__cause__ or error
            if raised is not None:
                raise raised  # here, so that the two are not each other's reason
        self._system.set_state(x)
        self._retired.clear()

    # -- the linear solver, as PETSc's preconditioner ----------------------------------------------

    def setUp(self, pc: PETSc.PC) -> None:
        """PETSc calls this after the matrix has changed."""
        (self._system.damping if self._damped else self._system.factors).setUp(pc)

    def apply(self, pc: PETSc.PC, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """Solve for a step; ``pc`` is marked as failed if the matrix cannot be factorised."""
        if self._damped:
            self._system.damping.apply(pc, right, solution)
        else:
            self._system.factors.apply(pc, right, solution, self._correction, self._last_fall)

    # -- callbacks of SNES -------------------------------------------------------------------------

    def _form_residual(self, _snes: Any, x: PETSc.Vec, residual: PETSc.Vec) -> None:
        with self._system.profile.phase("residual"):
            self._system.set_state(x)
            self._model.assemble_equations(residual)

    def _form_tangent(self, snes: PETSc.SNES, x: PETSc.Vec, *_matrices: Any) -> None:
        tangent = self._system.tangent
        with self._system.profile.phase("tangent"):
            self._system.set_state(x)
            if self._damped or self.rules.overshot:
                self._model.carried.reset()  # only the energy's own tangent leads downhill
            before = tangent.matrix
            norm = float(snes.getFunctionNorm())
            self._model.set_residual(norm)
            self._last_fall = self._fall_to_the_end(norm)
            with self._first_controls(snes.getIterationNumber()):
                tangent.assemble(convex=self.rules.convex)
            if tangent.matrix is not before:
                self._retired.append(before)  # SNES still holds it until this call returns
                snes.setJacobian(self._form_tangent, tangent.matrix)
            if self.rules.changed_much:
                self._system.factors.renew()
            self._correction = self._corrected_step()

    def _fall_to_the_end(self, norm: float) -> float:
        """The part of a residual's norm (N) that is its tolerance; infinite if it is not close."""
        if norm > self._system.policy.factors.close * self.rules.first_N:
            return np.inf
        return self.rules.tolerance_N(self._model.scale_N()) / norm

    def _corrected_step(self) -> CorrectedStep | None:
        """The step's equations if lagged quantities must change along it, else None."""
        if self._damped or not self.lagging.current:
            return None
        # a contact without pairs has no force that might lag
        self.lagging.corrected = bool(self._model.lagged_terms)
        matrix, policy = self._system.tangent.matrix, self._system.policy.correction
        step = CorrectedStep(self._model, matrix, policy)
        return step if step.any else None

    @contextmanager
    def _first_controls(self, iteration: int) -> Iterator[None]:
        """A context with the controls of the first tangent; time is not among them."""
        if iteration or not self._before:
            yield
            return
        now = {name: self._model.controls[name].value for name in self._before}
        self._model.prescribe(self._before)
        yield
        self._model.prescribe(now)

    def _bound_step(self, x: PETSc.Vec, y: PETSc.Vec) -> bool:
        """Shorten SNES' step (x − y) to its admissible part; let the carried stress follow."""
        system, unknowns = self._system, self._model.unknowns
        with system.profile.phase("step bound"):
            system.set_state(x)
            step = unknowns.to_local(-y.array_r)
            fraction = 1.0
            mixed = len(unknowns.fields) > 1
            if self._damped and mixed and system.along(step) > 0:
                # the damped step descends in the displacement: it is the pressure that ascends
                step = condensing_step(self._model)
            else:
                fraction = self.rules.fraction(step)
                if self._damped:
                    system.damping.adapt(fraction)
            system.watch.stepped(fraction, self.rules.bound)
            step *= fraction
            self._model.carried.follow(*unknowns.parts(step))
            y.array[:] = -unknowns.owned_part(step)
        return True

    def _converged(
        self, _snes: Any, iteration: int, norms: tuple[float, float, float], *_: Any
    ) -> int:
        rules, scale = self.rules, self._model.scale_N()
        verdict = rules.judge(iteration, norms[2], scale)
        self._system.watch.judged(iteration, norms[2], rules.tolerance_N(scale))
        if self._updates_lagged(verdict, norms[2]):
            residual = self._system.residual
            self._model.assemble_equations(residual)  # which SNES goes on with
            norm = float(residual.norm())
            self.lagging.updated(norm)
            verdict = rules.judge_anew(iteration, norm, scale)
        if verdict is IterationVerdict.GO_ON and is_late(self._model.comm, self._end_s):
            self.late, verdict = True, IterationVerdict.HOPELESS
        return int((IterationVerdict.HOPELESS if self.lagging.lost else verdict).value)

    def _updates_lagged(self, verdict: IterationVerdict, norm: float) -> bool:
        """Let terms update lagged quantities if due; return whether the potential changed."""
        if verdict is IterationVerdict.GO_ON:
            due = self.lagging.is_due(norm, self.rules.first_N)
        else:
            due = verdict is IterationVerdict.CONVERGED and self.lagging.is_due_at_the_end()
        return due and self._model.update_lagged()
