"""A job and its answer, as they are sent, spooled and stored, and when a job is given up."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from dolfingrip import plugins

Data = dict[str, Any]
"""Plain data: what JSON can hold."""

Status = Literal["done", "failed", "broken"]
"""``done`` and ``failed`` say something of the job. ``broken`` says that the machine did not let it
come to an end, however often it was tried; such an answer is not stored."""

REFUSED = "geometry"
"""Failure class of a job whose function refuses its arguments: there is no such finger or mesh."""


ERROR = "error"
"""Failure class of a job whose function has a fault."""

MACHINE = "machine"
"""Failure class of a job that the machine could not compute; the job itself may be good."""


class JobFailure(Exception):
    """A job that has no result.

    Attributes:
        kind: failure class, e.g. that of the load path.
        sentence: why, for people.
        partial: what there was before the failure.
    """

    def __init__(self, kind: str, sentence: str, partial: Data | None = None) -> None:
        super().__init__(kind, sentence, partial)
        self.kind, self.sentence, self.partial = kind, sentence, partial


@dataclass(frozen=True, slots=True)
class Job:
    """A call of a function, whose answer is kept.

    Attributes:
        key: hash of all that the result depends on, see :func:`content_key`.
        function: import path ``module:function``. The function returns :data:`Data`, and raises
            :class:`JobFailure` where there is no result.
        arguments: of the function, by name.
        inputs: by what this job differs from the others of its store, for people and tables.
        plugins: files that a worker takes, with their digests.
    """

    key: str
    function: str
    arguments: Data
    inputs: Data = field(default_factory=dict)
    plugins: Mapping[str, str] = field(default_factory=plugins.digests_of_files)


@dataclass(slots=True)
class JobResult:
    """A job's result or failure, and its cost.

    Attributes:
        key: of the job.
        status: one of :data:`Status`; only a job that is ``done`` has a result.
        result: what the function returned.
        partial: what there was before the failure.
        failure_class, failure: class and sentence.
        started_at: UTC, ISO 8601.
        wall_s: time of the computation.
        worker: host and process.
        broken: sentences of the attempts that the machine did not let come to an end.
    """

    key: str
    status: Status
    result: Data | None = None
    partial: Data | None = None
    failure_class: str | None = None
    failure: str | None = None
    started_at: str | None = None
    wall_s: float | None = None
    worker: str | None = None
    broken: list[str] = field(default_factory=list)

    def dumps(self) -> str:
        """JSON on one line, with its digest; numbers that JSON does not have become null."""
        content = _plain(asdict(self))
        return json.dumps(content | {"digest": content_key(content)}, allow_nan=False)

    @staticmethod
    def loads(text: str) -> JobResult:
        """The answer in a JSON text.

        Raises:
            ValueError: where the text is none, or is damaged.
        """
        try:
            content = json.loads(text)
            if content.pop("digest") != content_key(content):
                raise ValueError("its digest is that of another content")
            return JobResult(**content)
        except (TypeError, AttributeError, KeyError, RecursionError) as error:
            raise ValueError(str(error)) from None


def content_key(content: Data) -> str:
    """Hash of plain data.

    Args:
        content: plain data that the result depends on.

    Returns:
        The key: hexadecimal digits.
    """
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


@dataclass(frozen=True, slots=True)
class WorkerPolicy:
    """How often workers may fail, and for how long they are waited for.

    Attributes:
        lost_workers: workers that may die on a job before it is given up.
        attempts: how often a worker tries a job that the machine does not let come to an end.
        pause_s: time before the second attempt, and twice as long before the next.
        starts: attempts to start a local worker until it is ready for the first time.
        start_check_s: time between two looks at a local worker that starts.
        connect_s: time to reach a scheduler that is said to run.
        silence_h: time without a word after which a worker counts as lost. A factorisation holds
            the interpreter for long, and a cold disk alone can take longer than Dask's own 15 s.
    """

    lost_workers: int = 2
    attempts: int = 3
    pause_s: float = 1.0
    starts: int = 10
    start_check_s: float = 0.05
    connect_s: float = 20.0
    silence_h: float = 1.0
