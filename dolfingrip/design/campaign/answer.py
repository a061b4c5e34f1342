"""What computing a design gives, as it is spooled, sent and stored."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

Status = Literal["done", "failed"]

WORKER_LOST = "worker lost"
"""Failure class of a design whose workers died too often for chance."""


class DesignFailure(Exception):
    """A design that has no result.

    Attributes:
        kind: failure class, e.g. that of the load path.
        sentence: why, for people.
        curve: the readings before the failure, by column.
    """

    def __init__(self, kind: str, sentence: str, curve: dict[str, Any] | None = None) -> None:
        super().__init__(kind, sentence, curve)
        self.kind, self.sentence, self.curve = kind, sentence, curve


@dataclass(slots=True)
class Outcome:
    """What an objective function returns.

    Attributes:
        outputs: number by quantity, the unit in its name.
        gradients: by output its derivatives, by key of the parameter; None where not computed.
        curve: the readings, by column.
        iterations: of Newton's method.
        versions: of the software that computed it, by package.
    """

    outputs: dict[str, float]
    gradients: dict[str, dict[str, float]] | None = None
    curve: dict[str, Any] | None = None
    iterations: int | None = None
    versions: dict[str, str] = field(default_factory=dict)


@dataclass(slots=True)
class Answer:
    """A design's outcome or failure, and its cost.

    Attributes:
        key: of the design.
        status: ``failed`` leaves ``outputs`` empty: no number of a failed design is kept.
        failure_class, failure: class and sentence.
        started_at: UTC, ISO 8601.
        wall_s: time of the computation.
        worker: host and process.
    """

    key: str
    status: Status
    outputs: dict[str, float] = field(default_factory=dict)
    gradients: dict[str, dict[str, float]] | None = None
    curve: dict[str, Any] | None = None
    failure_class: str | None = None
    failure: str | None = None
    iterations: int | None = None
    started_at: str | None = None
    wall_s: float | None = None
    worker: str | None = None
    versions: dict[str, str] = field(default_factory=dict)

    def dumps(self) -> str:
        """JSON on one line; numbers that JSON has not become null."""
        return json.dumps(_plain(asdict(self)), allow_nan=False)

    @staticmethod
    def loads(text: str) -> Answer:
        """The answer in a JSON text.

        Raises:
            ValueError: where the text is none.
        """
        try:
            return Answer(**json.loads(text))
        except TypeError as error:
            raise ValueError(str(error)) from None


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
