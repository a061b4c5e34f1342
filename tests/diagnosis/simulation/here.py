"""Workers that compute in this process: the same store, and no time to start others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dolfingrip.diagnosis.simulation.job import SHARED, Job, JobResult, calls
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.jobs.store import Store
from dolfingrip.jobs.work import compute


@dataclass(frozen=True, slots=True)
class Here(Workers):
    """Fills the store before the workers are asked, who then have nothing to compute."""

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        with Store(self.store, write=True) as store:
            store.add(calls(jobs), SHARED)
            for call in calls(jobs):
                if store.status(call.key) == "pending":
                    store.record(compute(call))
        return Workers.results(self, jobs)
