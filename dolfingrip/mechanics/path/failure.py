"""Why a load step failed: classes, and a sentence for each."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class FailureKind(StrEnum):
    """What stopped the path."""

    INVERTED_ELEMENT = "inverted element"
    CONTACT = "contact"
    LIMIT_POINT = "limit point"
    ITERATION_LIMIT = "iteration limit"
    TIME_LIMIT = "time limit"


_SENTENCE = {
    FailureKind.INVERTED_ELEMENT: (
        "an element turned inside out; refine the mesh or lower the pressure"
    ),
    FailureKind.CONTACT: (
        "contact kept Newton's steps short; widen contact.barrier_mm or lower its stiffness"
    ),
    FailureKind.LIMIT_POINT: (
        "the finger goes soft here (its stiffness vanishes): pressure control cannot follow it"
    ),
    FailureKind.ITERATION_LIMIT: ("Newton's method did not converge within solver.max_iterations"),
    FailureKind.TIME_LIMIT: "solver.time_limit_s is over",
}


@dataclass(frozen=True, slots=True)
class Failure:
    """A classified failure of a load step.

    Attributes:
        kind: the class.
        last_good: controls of the last converged state, by name.
        advice: what goes on from there, as the caller of the path knows; "" where nothing does.
    """

    kind: FailureKind
    last_good: dict[str, float]
    advice: str = ""

    def sentence(self) -> str:
        """One sentence with the last good pressure (or other controls), and the advice."""
        reached = ", ".join(
            f"{value:zg} {name.rpartition('_')[2]}"
            for name, value in self.last_good.items()
            if name != "time_s"
        )
        said = f"stopped at {reached} ({self.kind}): {_SENTENCE[self.kind]}"
        return f"{said}; {self.advice}" if self.advice else said
