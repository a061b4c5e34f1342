"""Workers that keep what they were asked for, so that it can be written to a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from dolfingrip.diagnosis.simulation.job import Job, JobResult
from dolfingrip.diagnosis.workers import StayingWorkers


@dataclass(frozen=True, slots=True)
class Remembering(StayingWorkers):
    """Workers that keep what they were asked for.

    Attributes:
        asked: jobs and their results, by key.
    """

    asked: dict[str, tuple[Job, JobResult]] = field(default_factory=dict)

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        """Results of jobs, which are remembered."""
        found = StayingWorkers.results(self, jobs)
        for job, result in zip(jobs, found, strict=True):
            self.asked[job.key] = (job, result)
        return found

    def remembered(self) -> tuple[list[Job], list[JobResult]]:
        """Jobs and their results, in the order in which they were asked for."""
        pairs = list(self.asked.values())
        return [job for job, _ in pairs], [result for _, result in pairs]
