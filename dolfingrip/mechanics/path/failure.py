"""Why a load step failed."""

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


@dataclass(frozen=True, slots=True)
class Failure:
    """A classified failure of a load step.

    Attributes:
        kind: the class.
        last_good: controls of the last converged state, by name.
        words: what the class means, as the caller of the path says; "" where it says nothing.
        advice: what goes on from there, as the caller knows; "" where nothing does.
    """

    kind: FailureKind
    last_good: dict[str, float]
    words: str = ""
    advice: str = ""

    def sentence(self) -> str:
        """One sentence with the last good controls, the words and the advice."""
        reached = ", ".join(
            f"{value:zg} {name.rpartition('_')[2]}"
            for name, value in self.last_good.items()
            if name != "time_s"
        )
        said = "; ".join(filter(None, (self.words, self.advice)))
        stopped = f"stopped at {reached} ({self.kind})"
        return f"{stopped}: {said}" if said else stopped
