"""Workers that keep what they were asked for, so that it can be written to a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from dolfingrip.diagnosis.simulation.job import Job, JobResult, result_of
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.jobs.store import Store


@dataclass(frozen=True, slots=True)
class Remembering(Workers):
    """Workers that keep what they were asked for.

    Attributes:
        asked: jobs by key, in the order in which they were asked for.
    """

    asked: dict[str, Job] = field(default_factory=dict)

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        """Results of jobs, which are remembered."""
        self.asked.update({job.key: job for job in jobs})
        return Workers.results(self, jobs)

    def remembered(self) -> tuple[list[Job], list[JobResult]]:
        """Those jobs that have ended, and their results."""
        with Store(self.store) as store:
            rows = {row["key"]: row for row in store.rows() if row["status"] != "pending"}
        ended = [job for key, job in self.asked.items() if key in rows]
        return ended, [result_of(rows[job.key]) for job in ended]
