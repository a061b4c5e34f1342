"""Workers that stay: a diagnosis asks for simulations many times, and starts processes once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from dolfingrip.config import ConfigError
from dolfingrip.design.campaign.campaign import Standing
from dolfingrip.design.campaign.cluster import Where, connected
from dolfingrip.design.campaign.store import Store
from dolfingrip.diagnosis.simulation.job import Job, JobResult
from dolfingrip.diagnosis.simulation.runner import Workers


@dataclass(frozen=True, slots=True)
class StayingWorkers(Workers):
    """Workers whose processes are started when something is to be computed, and kept.

    Attributes:
        stack: what ends with them.
        addresses: of the scheduler, once there is one.
        spent_s: time that each simulation took, by its key.
    """

    stack: ExitStack = field(default_factory=ExitStack)
    addresses: list[str] = field(default_factory=list)
    spent_s: dict[str, float] = field(default_factory=dict)

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        """As :meth:`Workers.results`."""
        if not self.addresses and self._missing(jobs):
            client = self.stack.enter_context(connected(self.where))
            self.addresses.append(client.scheduler.address)
        where = Where(scheduler=self.addresses[0]) if self.addresses else self.where
        found = Workers(self.store, where, self.progress, self.retry_failed).results(jobs)
        for job, result in zip(jobs, found, strict=True):
            self.spent_s[job.key] = result.wall_s or 0.0
        return found

    def _missing(self, jobs: Sequence[Job]) -> bool:
        try:
            with Store(self.store) as store:
                return any(store.status(job.key) in (None, "pending") for job in jobs)
        except ConfigError:
            return True


@contextmanager
def staying(
    store: Path, workers: int, progress: Callable[[Standing], None]
) -> Iterator[StayingWorkers]:
    """Workers that end with the ``with`` block.

    Args:
        store: folder of the results.
        workers: number of processes.
        progress: called with each simulation that is done.
    """
    with ExitStack() as stack:
        yield StayingWorkers(store, Where(workers=workers), progress, stack=stack)
