"""Newton's method: PETSc SNES with a symmetric factorisation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import Guess
from dolfingrip.mechanics.newton import damping
from dolfingrip.mechanics.newton.ending import Counts, Solve, ending_of
from dolfingrip.mechanics.newton.iterations import PREFIX, Iterations, System
from dolfingrip.mechanics.newton.policy import NewtonPolicy
from dolfingrip.sections.numerics import Solver


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
        tangent: the model's tangent.
    """

    def __init__(
        self,
        model: Model,
        settings: Solver,
        profile: Profile | None = None,
        policy: NewtonPolicy | None = None,
        counts: Counts | None = None,
    ) -> None:
        self.model, self.settings = model, settings
        self.profile, self.counts = profile or Profile(), counts or Counts()
        policy = policy or NewtonPolicy()
        self._system = system = System(model, settings, self.profile, policy, self.counts)
        self.tangent, self.linear_solver = system.tangent, system.linear_solver
        self.watch = system.watch
        # SNES never gets u's own vector: values are copied in and out (FEniCS/dolfinx#3507)
        self._x = system.residual.duplicate()
        self._snes = _create_snes(model.comm)

    def of(self, model: Model) -> Newton:
        """A solver of another model with these settings and counts."""
        policy = self._system.policy
        made = Newton(model, self.settings, self.profile, policy, self.counts)
        made.watch.tell = self.watch.tell
        return made

    def solve(
        self,
        guess: Guess | None = None,
        *,
        damped: bool = False,
        before: Mapping[str, float] | None = None,
        again: bool = True,
        iterations: int | None = None,
        end_s: float = math.inf,
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
            end_s: time on the monotonic clock after which no further iteration begins.
        """
        here = self.model.unknowns.local()
        lagged = self.model.lagged_state()
        self.watch.start()
        solve, overshot = self._iterate(guess, damped, before, iterations, end_s)
        if again and not solve.converged and overshot:
            self.model.unknowns.set_local(here)
            self.model.restore_lagged(lagged)
            second, _ = self._iterate(guess, damped, before, iterations, end_s, corrected=False)
            solve = replace(second, iterations=solve.iterations + second.iterations)
        self.counts.damped += damped and solve.converged
        return solve

    def _iterate(
        self,
        guess: Guess | None,
        damped: bool,
        before: Mapping[str, float] | None,
        iterations: int | None,
        end_s: float,
        *,
        corrected: bool = True,
    ) -> tuple[Solve, bool]:
        """Iterate from one start; the arguments are those of :meth:`solve`.

        Returns:
            The outcome, and whether a step with a correction for lagged quantities overshot.
        """
        factor = damping.ITERATIONS if damped else 1
        allowed = self.settings.max_iterations * factor
        self._snes.setTolerances(max_it=min(allowed, iterations or allowed))
        course = Iterations(
            self._system,
            guess,
            damped=damped,
            corrected=corrected,
            before=before or {},
            end_s=end_s,
        )
        course.run(self._snes, self._x)
        taken = self._snes.getIterationNumber()
        self.counts.iterations += taken
        ending = ending_of(self._snes.getConvergedReason(), course.rules, late=course.late)
        return Solve(ending, taken, self._system.damping.unstable), course.lagging.overshot

    def linear(self, *, near: bool = False) -> Callable[[np.ndarray], np.ndarray]:
        """K⁻¹ at the model's present state.

        Args:
            near: whether factors of the last iterations may serve, with conjugate gradients and
                until the next solve; else K is factorised once.

        Returns:
            A function of owned arrays in the order of a vector: (n,), or (n, k) for k of them,
            which are solved for at once.
        """
        factors = self._system.factors
        self.model.carried.reset()
        self.model.set_residual(0.0)
        self.tangent.assemble()
        factors.take(self.tangent.matrix, near=near)

        def solve(values: np.ndarray) -> np.ndarray:
            right = values if values.ndim == 2 else values[:, None]
            return factors.solve_many(right).reshape(values.shape)

        return solve


def _create_snes(comm: MPI.Comm) -> PETSc.SNES:
    """SNES without a line search of its own, whose linear solver is applied once a step."""
    snes = PETSc.SNES().create(comm)
    snes.setOptionsPrefix(PREFIX)
    snes.setType(PETSc.SNES.Type.NEWTONLS)
    ksp = snes.getKSP()
    ksp.setType(PETSc.KSP.Type.PREONLY)
    ksp.getPC().setType(PETSc.PC.Type.PYTHON)
    options = PETSc.Options(PREFIX)
    options["snes_linesearch_type"] = "basic"
    # a rising residual is no failure: see Globalisation
    options["snes_divergence_tolerance"] = -1
    snes.setFromOptions()
    return snes
