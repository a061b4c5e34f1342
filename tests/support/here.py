"""Workers that compute in this process: the same store, and no time to start others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.experiments.simulate import SHARED, job
from dolfingrip.jobs.store import Store
from dolfingrip.jobs.work import compute


@dataclass(frozen=True, slots=True)
class Here(Workers):
    """Fills the store before the workers are asked, who then have nothing to compute."""

    def results(self, requests: Sequence[Request]) -> list[Answer]:
        jobs = list({each.key: job(each) for each in requests}.values())
        with Store(self.store, write=True) as store:
            store.add(jobs, SHARED)
            for each in jobs:
                if store.status(each.key) == "pending":
                    store.record(compute(each))
        return Workers.results(self, requests)
