"""Why a load step failed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class FailureKind(StrEnum):
    """The classes of failures."""

    INVERTED_ELEMENT = "inverted element"
    CONTACT = "contact"
    LIMIT_POINT = "limit point"
    ITERATION_LIMIT = "iteration limit"
    TIME_LIMIT = "time limit"


@dataclass(frozen=True, slots=True)
class Failure:
    """A classified failure of a load step.

    Attributes:
        kind: class of the failure.
        last_good: controls of the last converged state, by name.
        words: meaning of the class, in words of the path's caller; "" if it has none.
        advice: how to go on from there, in words of the path's caller; "" if nothing is known.
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
