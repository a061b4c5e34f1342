"""Workers that stay: a diagnosis asks for simulations many times, and starts processes once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from dolfingrip.config import ConfigError
from dolfingrip.design.campaign.campaign import Standing
from dolfingrip.design.campaign.cluster import Where, connected
from dolfingrip.design.campaign.store import Store
from dolfingrip.diagnosis.simulation import shipped
from dolfingrip.diagnosis.simulation.job import Batch, Job, JobResult
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.shipped import Shipped


class NotAtHand(Exception):
    """Simulations would have to be computed; the text says how many."""


@dataclass(frozen=True, slots=True)
class StayingWorkers(Workers):
    """Workers whose processes are started when something is to be computed, and kept.

    Attributes:
        stack: what ends with them.
        addresses: of the scheduler, once there is one.
        spent_s: time that each simulation took, by its key.
        known: results that come with the package, which are entered instead of being computed.
        computes: whether what is not there is computed.
    """

    stack: ExitStack = field(default_factory=ExitStack)
    addresses: list[str] = field(default_factory=list)
    spent_s: dict[str, float] = field(default_factory=dict)
    known: Shipped | None = None
    computes: bool = True

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        """As :meth:`Workers.results`."""
        self._enter_known(self._missing(jobs))
        if not self.computes and (missing := self._missing(jobs)):
            raise NotAtHand(f"{len(missing)} simulations are not at hand")
        return self._computed(jobs)

    def at_hand(self) -> StayingWorkers:
        """The same, which raise :class:`NotAtHand` where something is missing."""
        return replace(self, computes=False)

    def _computed(self, jobs: Sequence[Job]) -> list[JobResult]:
        if not self.addresses and self._missing(jobs):
            client = self.stack.enter_context(connected(self.where))
            self.addresses.append(client.scheduler.address)
        where = Where(scheduler=self.addresses[0]) if self.addresses else self.where
        found = Workers(self.store, where, self.progress, self.retry_failed).results(jobs)
        for job, result in zip(jobs, found, strict=True):
            self.spent_s[job.key] = result.wall_s or 0.0
        return found

    def _enter_known(self, missing: Sequence[Job]) -> None:
        """Enter what comes with the package."""
        if self.known is None or not missing:
            return
        found = self.known.answers(missing, lambda job: self._computed([job])[0])
        if not found:
            return
        batch = Batch([job for job, _ in found])
        with Store(self.store, write=True) as store:
            store.add(batch.facts(), batch.designs())
            for _, answer in found:
                store.record(answer)

    def _missing(self, jobs: Sequence[Job]) -> list[Job]:
        try:
            with Store(self.store) as store:
                return [job for job in jobs if store.status(job.key) in (None, "pending")]
        except ConfigError:
            return list(jobs)


@contextmanager
def staying(
    store: Path,
    workers: int,
    progress: Callable[[Standing], None],
    *,
    anew: bool = False,
) -> Iterator[StayingWorkers]:
    """Workers that end with the ``with`` block.

    Args:
        store: folder of the results.
        workers: number of processes.
        progress: called with each simulation that is done.
        anew: compute what comes with the package, too.
    """
    known = None if anew else shipped.read()
    with ExitStack() as stack:
        yield StayingWorkers(store, Where(workers=workers), progress, stack=stack, known=known)
