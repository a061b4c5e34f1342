"""Workers of jobs that are this process."""

from __future__ import annotations

from collections.abc import Generator, Sequence

from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.job import Job, JobResult
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.work import work


class ThisProcess(Pool):
    """Computes one job after another, here."""

    def __init__(self) -> None:
        super().__init__(Where())

    def answers(self, jobs: Sequence[Job], spool: Spool) -> Generator[JobResult]:
        """Compute jobs, in their order."""
        for each in jobs:
            yield work(each, spool.folder)
