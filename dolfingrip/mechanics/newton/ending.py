"""How a solve of Newton's method ends."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from petsc4py import PETSc

from dolfingrip.mechanics.model.model import INVERTED
from dolfingrip.mechanics.newton.globalisation import Globalisation, Verdict

REASON = {
    Verdict.GO_ON: PETSc.SNES.ConvergedReason.CONVERGED_ITERATING,
    Verdict.CONVERGED: PETSc.SNES.ConvergedReason.CONVERGED_FNORM_RELATIVE,
    Verdict.NOT_A_NUMBER: PETSc.SNES.ConvergedReason.DIVERGED_FNORM_NAN,
    Verdict.STUCK: PETSc.SNES.ConvergedReason.DIVERGED_LINE_SEARCH,
    Verdict.HOPELESS: PETSc.SNES.ConvergedReason.DIVERGED_DTOL,
}
"""PETSc's reason for each verdict."""


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
        unstable: whether a damped solve met states that are not stable.
    """

    ending: Ending
    iterations: int
    unstable: bool = False

    @property
    def converged(self) -> bool:
        """Whether the residual met its tolerance."""
        return self.ending is Ending.CONVERGED


def ending_of(reason: int, rules: Globalisation) -> Ending:
    """The ending of a solve that follows from PETSc's reason and the rules of its steps."""
    reasons = PETSc.SNES.ConvergedReason
    if reason > 0:
        return Ending.CONVERGED
    if rules.stuck:
        return Ending.INVERTED if rules.bound == INVERTED else Ending.BLOCKED
    if reason == reasons.DIVERGED_MAX_IT:
        return Ending.ITERATIONS
    if reason == reasons.DIVERGED_LINEAR_SOLVE:
        return Ending.SINGULAR
    return Ending.DIVERGED
