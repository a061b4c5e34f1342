"""Workers that stay: a diagnosis asks for simulations many times, and starts processes once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.simulation import shipped
from dolfingrip.diagnosis.simulation.job import SHARED, Job, JobResult, calls
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.shipped import Shipped
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress
from dolfingrip.jobs.store import Store


class NotAtHand(Exception):
    """Simulations would have to be computed; the text says how many."""


@dataclass(frozen=True, slots=True)
class StayingWorkers(Workers):
    """Workers whose processes are started when something is to be computed, and kept.

    Attributes:
        kept: the processes; started for each call where None.
        spent_s: time that each simulation took, by its key.
        known: results that come with the package, which are entered instead of being computed.
        computes: whether what is not there is computed.
    """

    kept: Pool | None = None
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

    def pool(self) -> AbstractContextManager[Pool]:
        """The processes that are kept."""
        return Workers.pool(self) if self.kept is None else nullcontext(self.kept)

    def _computed(self, jobs: Sequence[Job]) -> list[JobResult]:
        found = Workers.results(self, jobs)
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
        with Store(self.store, write=True) as store:
            store.add(calls([job for job, _ in found]), SHARED)
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
    progress: Progress,
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
    where = Where(workers=workers)
    with Pool(where) as pool:
        yield StayingWorkers(store, where, progress, kept=pool, known=known)
