"""Newton's method: PETSc SNES with a symmetric factorisation."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import Guess
from dolfingrip.mechanics.newton.callbacks import callback, context
from dolfingrip.mechanics.newton.damping import Damping
from dolfingrip.mechanics.newton.ending import REASON, Counts, Solve, Watch, ending_of
from dolfingrip.mechanics.newton.factors import Factors
from dolfingrip.mechanics.newton.globalisation import Globalisation, Verdict
from dolfingrip.mechanics.newton.lagging import CorrectedStep, LagRules
from dolfingrip.mechanics.newton.linear_solver import LinearSolver
from dolfingrip.mechanics.newton.mixed_tangent import Condensation, MixedTangent
from dolfingrip.mechanics.newton.policy import NewtonPolicy
from dolfingrip.mechanics.newton.tangent import Tangent
from dolfingrip.sections.numerics import Solver

PREFIX = "dolfingrip_"
"""Prefix of PETSc's options."""


class Newton:
    """Finds a stationary point of a model's Π from its present state.

    Args:
        model: model whose unknowns are solved for.
        settings: tolerances and limits.
        profile: takes the time of each phase.
        policy: numbers behind its decisions.
        counts: counts to add to; default: from 0 on.

    Attributes:
        counts: counts of iterations, factorisations and damped solves.
        linear_solver: how it solves with tangents.
        watch: tells how a long solve goes on.
    """

    def __init__(
        self,
        model: Model,
        settings: Solver,
        profile: Profile | None = None,
        policy: NewtonPolicy | None = None,
        counts: Counts | None = None,
    ) -> None:
        model.potential.compile()
        self.model = model
        self.settings = settings
        self.profile = profile or Profile()
        self.counts = counts or Counts()
        self._policy = policy = policy or NewtonPolicy()
        mixed = len(model.unknowns.fields) > 1
        self.tangent = MixedTangent(model) if mixed else Tangent(model)
        self.linear_solver = linear = LinearSolver(model, self.tangent, settings)
        self._factors = Factors(
            PREFIX,
            linear.inverse(PREFIX),
            policy.multigrid if linear.iterative else policy.factors,
            self.counts,
            spare=lambda: linear.factors(PREFIX + "spare_"),
            spare_policy=policy.factors,
        )
        self._residual = model.unknowns.create_vector()
        # SNES never gets u's own vector: values are copied in and out (FEniCS/dolfinx#3507)
        self._x = self._residual.duplicate()
        self._trial = self._residual.duplicate()
        self._retired: list[PETSc.Mat] = []
        self._globalisation = Globalisation(
            model, settings, callback(self._residual_along), policy.steps
        )
        self._lagging = LagRules(model, policy.lag)
        self._damping = Damping(
            lambda: linear.with_inertia(PREFIX + "damped_"),
            model,
            self.tangent,
            policy.damping,
            self.counts,
        )
        self._condensation = Condensation(model) if mixed else None
        self.watch = Watch()
        self._damped = False
        self._before: Mapping[str, float] = {}
        self._snes = self._make_snes()

    def of(self, model: Model) -> Newton:
        """A solver of another model with these settings and counts."""
        made = Newton(model, self.settings, self.profile, self._policy, self.counts)
        made.watch.tell = self.watch.tell
        return made

    def _make_snes(self) -> PETSc.SNES:
        snes = PETSc.SNES().create(self.model.comm)
        snes.setOptionsPrefix(PREFIX)
        snes.setType(PETSc.SNES.Type.NEWTONLS)
        snes.setFunction(callback(self._form_residual), self._residual)
        snes.setJacobian(callback(self._form_tangent), self.tangent.matrix)
        snes.setConvergenceTest(callback(self._converged))
        snes.setLineSearchPreCheck(callback(self._bound_step))
        ksp = snes.getKSP()
        ksp.setType(PETSc.KSP.Type.PREONLY)
        ksp.getPC().setType(PETSc.PC.Type.PYTHON)
        options = PETSc.Options(PREFIX)
        options["snes_linesearch_type"] = "basic"
        # a rising residual is no failure: see Globalisation
        options["snes_divergence_tolerance"] = -1
        snes.setFromOptions()
        return snes

    # -- callbacks -----------------------------------------------------------------------------

    def _take(self, x: PETSc.Vec) -> None:
        """Copy SNES' iterate into the unknowns and their ghosts."""
        self.model.unknowns.set_owned(x.array_r)

    def _residual_norm(self) -> float:
        self.model.assemble_equations(self._trial)
        return float(self._trial.norm())

    def _residual_along(self, step: np.ndarray) -> float:
        """Product of the residual with a local array of the unknowns."""
        self.model.assemble_equations(self._trial)
        own = self._trial.array_r @ self.model.unknowns.owned_part(step)
        return float(self.model.comm.allreduce(own, MPI.SUM))

    def _form_residual(self, _snes: Any, x: PETSc.Vec, residual: PETSc.Vec) -> None:
        with self.profile.phase("residual"):
            self._take(x)
            self.model.assemble_equations(residual)

    def _form_tangent(self, snes: PETSc.SNES, x: PETSc.Vec, *_matrices: Any) -> None:
        with self.profile.phase("tangent"):
            self._take(x)
            if self._damped or self._globalisation.overshot:
                self.model.carried.reset()  # only the energy's own tangent leads downhill
            before = self.tangent.matrix
            norm = float(snes.getFunctionNorm())
            self.model.set_residual(norm)
            self._factors.last_fall = self._fall_to_the_end(norm)
            with self._first_controls(snes.getIterationNumber()):
                self.tangent.assemble()
            if self.tangent.matrix is not before:
                self._retired.append(before)  # SNES still holds it until this call returns
                snes.setJacobian(callback(self._form_tangent), self.tangent.matrix)
            if self._globalisation.far:
                self._factors.renew()
            self._factors.corrected_step = self._corrected_step()

    def _fall_to_the_end(self, norm: float) -> float:
        """The part of a residual's norm (N) that is its tolerance; infinite if it is not close."""
        rules = self._globalisation
        if norm > self._policy.factors.close * rules.first_N:
            return np.inf
        return rules.tolerance_N(self.model.scale_N()) / norm

    def _corrected_step(self) -> CorrectedStep | None:
        """The step's equations if lagged quantities must change along it, else None."""
        if self._damped or not self._lagging.current:
            return None
        # a contact without pairs has no force that might lag
        self._lagging.corrected = bool(self.model.lagged_terms)
        step = CorrectedStep(self.model, self.tangent.matrix, self._policy.correction)
        return step if step.any else None

    @contextmanager
    def _first_controls(self, iteration: int) -> Iterator[None]:
        """A context with the controls of the first tangent; time is not among them."""
        if iteration or not self._before:
            yield
            return
        now = {name: self.model.controls[name].value for name in self._before}
        self.model.prescribe(self._before)
        yield
        self.model.prescribe(now)

    def _bound_step(self, x: PETSc.Vec, y: PETSc.Vec) -> bool:
        """Shorten SNES' step (x − y) to its admissible part; let the carried stress follow."""
        with self.profile.phase("step bound"):
            self._take(x)
            step = self.model.unknowns.to_local(-y.array_r)
            fraction = 1.0
            if self._damped and self._condensation and self._residual_along(step) > 0:
                # the damped step descends in the displacement: it is the pressure that ascends
                step = self._condensation.step()
            else:
                fraction = self._globalisation.fraction(step)
                if self._damped:
                    self._damping.adapt(fraction)
            self.watch.stepped(fraction, self._globalisation.bound)
            step *= fraction
            self.model.carried.follow(*self.model.unknowns.parts(step))
            y.array[:] = -self.model.unknowns.owned_part(step)
        return True

    def _converged(
        self, _snes: Any, iteration: int, norms: tuple[float, float, float], *_: Any
    ) -> int:
        rules, scale = self._globalisation, self.model.scale_N()
        verdict = rules.judge(iteration, norms[2], scale)
        self.watch.judged(iteration, norms[2], rules.tolerance_N(scale))
        if self._takes_anew(verdict, norms[2]):
            self.model.assemble_equations(self._residual)  # which SNES goes on with
            norm = float(self._residual.norm())
            self._lagging.updated(norm)
            verdict = rules.judge_anew(iteration, norm, scale)
        return REASON[Verdict.HOPELESS if self._lagging.lost else verdict]

    def _takes_anew(self, verdict: Verdict, norm: float) -> bool:
        """Let terms update lagged quantities if due; return whether the potential changed."""
        if verdict is Verdict.GO_ON:
            due = self._lagging.is_due(norm, self._globalisation.first_N)
        else:
            due = verdict is Verdict.CONVERGED and self._lagging.is_due_at_the_end()
        return due and self.model.update_lagged()

    # -- solve ---------------------------------------------------------------------------------

    def solve(
        self,
        guess: Guess | None = None,
        *,
        damped: bool = False,
        before: Mapping[str, float] | None = None,
        again: bool = True,
        iterations: int | None = None,
    ) -> Solve:
        """Iterate from the model's present state; the state is changed even if this fails.

        Corrected steps may lead far away, for example if a body nearly slips off. Such a solve
        starts again, with lagged quantities fixed along each step.

        Args:
            guess: another start; the tolerance still refers to the present state's residual.
            damped: whether each step is damped and searched along. This takes more and costlier
                iterations, but robustly follows a motion to a stable state.
            before: controls, without time, of the present state if it is in equilibrium. With them
                the first tangent is that of the equilibrium path. A pressure without the stress
                that bears it would soften it.
            again: whether a second start is allowed; a caller that halves its step forbids it.
            iterations: at most, if fewer than the settings allow.
        """
        here = self.model.unknowns.local()
        lagged = self.model.lagged_state()
        self._before = before or {}
        self.watch.start()
        solve = self._iterate(guess, damped=damped, iterations=iterations)
        if again and not solve.converged and self._lagging.overshot:
            self.model.unknowns.set_local(here)
            self.model.restore_lagged(lagged)
            self._before = before or {}
            second = self._iterate(guess, damped=damped, corrected=False, iterations=iterations)
            solve = replace(second, iterations=solve.iterations + second.iterations)
        self.counts.damped += damped and solve.converged
        return solve

    def _iterate(
        self, guess: Guess | None, *, damped: bool, corrected: bool = True, iterations: int | None
    ) -> Solve:
        """Iterate once through a solve; the arguments are those of :meth:`solve`."""
        model = self.model
        carried = model.carried
        self._prepare(damped, iterations)
        self._lagging.start(corrected=corrected)
        if guess is not None:
            most = self._policy.guess_residual_ratio
            first_N, here = self._residual_norm(), model.unknowns.local()
            model.unknowns.set_local(guess.unknowns)
            carried.values = guess.carried
            if most < np.inf and self._residual_norm() > most * first_N:
                model.unknowns.set_local(here)
                carried.reset()
            else:
                self._before = {}
                self._lagging.start(predicted=True, corrected=corrected)
            self._globalisation.start(first_N, far=True, damped=damped)
        else:
            self._globalisation.start(damped=damped)
            carried.reset()
        self._x.array[:] = model.unknowns.owned()
        with self.profile.phase("linear solve"):
            self._snes.solve(None, self._x)
        self._take(self._x)
        self._retired.clear()
        iterations = self._snes.getIterationNumber()
        self.counts.iterations += iterations
        return Solve(
            ending_of(self._snes.getConvergedReason(), self._globalisation),
            iterations,
            self._damping.unstable,
        )

    def linear(self) -> Callable[[np.ndarray], np.ndarray]:
        """K⁻¹ at the model's present state, factorised once.

        Returns:
            A function of owned arrays in the order of a vector: (n,), or (n, k) for k of them,
            which are solved for at once.
        """
        self._prepare(damped=False)
        self.model.carried.reset()
        self.model.set_residual(0.0)
        self.tangent.assemble()
        self._snes.setJacobian(callback(self._form_tangent), self.tangent.matrix)
        self._factors.factorise(self.tangent.matrix)

        def solve(values: np.ndarray) -> np.ndarray:
            right = values if values.ndim == 2 else values[:, None]
            return self._factors.solve_many(right).reshape(values.shape)

        return solve

    def _prepare(self, damped: bool, iterations: int | None = None) -> None:
        """Prepare SNES for a damped or an undamped solve of so many iterations at most."""
        self._damped = damped
        self._damping.start()
        solver = self._damping if damped else self._factors
        self._snes.getKSP().getPC().setPythonContext(context(solver.setUp, solver.apply))
        allowed = self.settings.max_iterations * (self._policy.damping.iterations if damped else 1)
        self._snes.setTolerances(max_it=min(allowed, iterations or allowed))
