"""When workers and attempts are given up."""

from __future__ import annotations

from dataclasses import dataclass


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
