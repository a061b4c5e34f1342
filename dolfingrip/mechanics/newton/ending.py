"""The course of a solve of Newton's method, its ending, and counts of all solves."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model.compilation import Tell
from dolfingrip.mechanics.model.model import INVERTED
from dolfingrip.mechanics.newton.globalisation import Globalisation


class Ending(StrEnum):
    """How a solve ended."""

    CONVERGED = "converged"
    ITERATIONS = "iteration limit"
    DIVERGED = "diverged"
    INVERTED = "inverted"
    BLOCKED = "blocked by contact"
    SINGULAR = "singular tangent"
    LATE = "time limit"


@dataclass(frozen=True, slots=True)
class Solve:
    """Outcome of one solve.

    Attributes:
        ending: converged, or why not.
        iterations: Newton iterations taken.
        unstable: whether a damped solve met states that are not stable.
    """

    ending: Ending
    iterations: int
    unstable: bool = False

    @property
    def converged(self) -> bool:
        """True if the residual met its tolerance."""
        return self.ending is Ending.CONVERGED


def ending_of(reason: int, rules: Globalisation, *, late: bool) -> Ending:
    """The ending of a solve that follows from PETSc's reason and the rules of its steps."""
    reasons = PETSc.SNES.ConvergedReason
    if reason > 0:
        return Ending.CONVERGED
    if late:
        return Ending.LATE
    if rules.stuck:
        return Ending.INVERTED if rules.bound == INVERTED else Ending.BLOCKED
    if reason == reasons.DIVERGED_MAX_IT:
        return Ending.ITERATIONS
    if reason == reasons.DIVERGED_LINEAR_SOLVE:
        return Ending.SINGULAR
    return Ending.DIVERGED


def is_late(comm: MPI.Comm, end_s: float) -> bool:
    """Return whether a time on the monotonic clock is over on any rank."""
    return end_s < math.inf and bool(comm.allreduce(time.monotonic() > end_s, MPI.LOR))


@dataclass(slots=True)
class Counts:
    """Counts since the start of a run.

    Attributes:
        iterations: Newton iterations, also those of failed solves.
        factorisations: factorisations of tangents.
        damped: number of damped solves that converged.
    """

    iterations: int = 0
    factorisations: int = 0
    damped: int = 0


class Watch:
    """Tells at each iteration, by a line once a solve takes longer than two seconds.

    Args:
        clock: in seconds.
        patience_s: time after which it tells by a line.

    Attributes:
        tell: receives each line, empty ones before that time; it may raise what ends the solve.
            None: nothing is told.
    """

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, patience_s: float = 2.0
    ) -> None:
        self._patience_s = patience_s
        self._clock = clock
        self.tell: Tell | None = None
        self.start()

    def start(self) -> None:
        """A new solve begins."""
        self._began_s = self._clock()
        self._step = ""

    def stepped(self, fraction: float, bound: str) -> None:
        """A step is taken: the part of Newton's step, and the name of what bounds it."""
        self._step = f", step {fraction:.2g} of Newton's"
        if bound:
            self._step += f", bounded by: {bound}"

    def judged(self, iteration: int, norm_N: float, tolerance_N: float) -> None:
        """The residual after so many iterations is known."""
        line = ""
        if self._clock() - self._began_s > self._patience_s:
            residual = f"residual {norm_N:.1e} N (to {tolerance_N:.1e} N)"
            line = f"iteration {iteration}: {residual}{self._step}"
        if self.tell is not None:
            self.tell(line)
