"""What somebody says of a case: the analyser or exact evidence, in the same words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from benchmarks.blind.exact.verdict import Verdict

Names = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Opinion:
    """An answer.

    Attributes:
        answer: ``cause``, ``none`` or ``unknown``.
        probability: that it is right.
        leading: effects of the most probable class, whatever the answer.
        named: the classes that are the cause: none, one or two.
    """

    answer: str
    probability: float
    leading: Names
    named: tuple[Names, ...]

    @classmethod
    def of_verdict(cls, verdict: Verdict) -> Opinion:
        """That of a verdict."""
        return cls(
            verdict.answer,
            verdict.probability,
            verdict.table[0].names if verdict.table else (),
            tuple(each.names for each in verdict.named),
        )

    @classmethod
    def of_file(cls, content: Mapping[str, Any]) -> Opinion:
        """That of a ``diagnosis.json``."""
        verdict = content["verdict"]
        named = [tuple(verdict["class"]), tuple(verdict.get("second", ()))]
        cause = verdict["answer"] == "cause"
        classes = content["classes"]
        return cls(
            verdict["answer"],
            verdict["probability"],
            tuple(classes[0]["effects"]) if classes else (),
            tuple(names for names in named if names) if cause else (),
        )

    def names(self, hidden: str) -> bool:
        """Whether the most probable class holds a cause."""
        return hidden in self.leading

    def claims(self, least: float) -> bool:
        """Whether a cause is named with at least this probability."""
        return self.answer == "cause" and self.probability >= least

    def right(self, hidden: Names) -> bool:
        """Whether each class that is named holds a hidden cause."""
        return bool(self.named) and all(set(each) & set(hidden) for each in self.named)


@dataclass(frozen=True, slots=True)
class Interval:
    """A fitted number's 90 % interval, and the truth.

    Attributes:
        key: of the number.
        low, high, true: in its unit.
    """

    key: str
    low: float
    high: float
    true: float

    @property
    def covers(self) -> bool:
        """Whether the truth is within."""
        return self.low <= self.true <= self.high


@dataclass(frozen=True, slots=True)
class Judged:
    """A case with both opinions.

    Attributes:
        name, protocol, kind, full: of the case.
        hidden: its causes.
        strengths_sigma: of each after nuisances.
        unexplained_sigma: of what no single effect of the catalogue explains.
        said: the analyser's opinion.
        bound: that of exact evidence.
        intervals: the analyser's, of the hidden cause.
        bound_intervals: those of exact evidence.
        cut: by how much the analyser's cause cuts the error on readings that are left out, as part
            of the error with nuisances alone; None where that was not measured.
        bound_cut: what the true model cuts.
        beats_rivals: whether the analyser says that the cause beats both of them.
        seconds: of processor.
    """

    name: str
    protocol: str
    kind: str
    full: bool
    hidden: Names
    strengths_sigma: tuple[float, ...]
    unexplained_sigma: float
    said: Opinion
    bound: Opinion
    intervals: tuple[Interval, ...] = ()
    bound_intervals: tuple[Interval, ...] = ()
    cut: float | None = None
    bound_cut: float | None = None
    beats_rivals: bool | None = None
    seconds: float = 0.0

    @property
    def sigma(self) -> float:
        """Strength (σ) of the strongest cause; 0 where there is none."""
        return max(self.strengths_sigma, default=0.0)

    @property
    def tied(self) -> bool:
        """Whether exact evidence cannot tell the hidden cause from another."""
        return any(len(names) > 1 and set(names) & set(self.hidden) for names in self.bound.named)
