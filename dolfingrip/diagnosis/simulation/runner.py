"""Many jobs on workers, each kept in a store by its content.

What is in the store is not computed again, whichever data asked for it; a diagnosis that is killed
goes on where it was (:mod:`dolfingrip.jobs.run`). What comes with the package
(:mod:`dolfingrip.diagnosis.simulation.shipped`) is entered instead of being computed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.simulation import shipped
from dolfingrip.diagnosis.simulation.job import SHARED, Job, JobResult, calls, result_of
from dolfingrip.diagnosis.simulation.shipped import Shipped
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress, run, silent
from dolfingrip.jobs.store import Store


class NotAtHand(Exception):
    """Simulations would have to be computed; the text says how many."""


@dataclass(frozen=True, slots=True)
class Workers:
    """Where simulations are computed and kept.

    Attributes:
        store: folder of the results, made where there is none.
        where: which workers; one MPI process each.
        progress: called with each simulation that is done.
        kept: processes that are started when something is to be computed, and kept; started for
            each call where None.
        known: results that come with the package.
        computes: whether what is not there is computed.
        spent_s: time that each simulation took, by its key.
    """

    store: Path
    where: Where = field(default_factory=Where)
    progress: Progress = silent
    kept: Pool | None = None
    known: Shipped | None = None
    computes: bool = True
    spent_s: dict[str, float] = field(default_factory=dict)

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        """What each of ``jobs`` gave, computed where it is not in the store.

        A simulation that fails has a result, too: its class, a sentence and what was read before.

        Raises:
            ConfigError: one line: no workers, or the store is in use or another's.
            NotAtHand: simulations are missing, and nothing is computed.
            SchedulerGone: the workers are gone; what was computed is kept.
        """
        if self.where.ranks != 1:
            raise ConfigError(f"--ranks {self.where.ranks}: allowed: 1 in a diagnosis")
        if self.known is not None:
            self._enter(self.known, self._missing(jobs))
        if not self.computes and (missing := self._missing(jobs)):
            raise NotAtHand(f"{len(missing)} simulations are not at hand")
        return self._computed(jobs)

    def at_hand(self) -> Workers:
        """The same, which raise :class:`NotAtHand` where something is missing."""
        return replace(self, computes=False)

    def pool(self) -> AbstractContextManager[Pool]:
        """The workers that compute what is missing; those not kept end with the ``with`` block."""
        return Pool(self.where) if self.kept is None else nullcontext(self.kept)

    def _computed(self, jobs: Sequence[Job]) -> list[JobResult]:
        keys = [job.key for job in jobs]
        if not keys:
            return []
        with self.pool() as pool:
            run(calls(jobs), self.store, pool, SHARED, progress=self.progress)
        with Store(self.store) as store:
            rows = {row["key"]: row for row in store.rows()}
        found = {key: result_of(rows[key]) for key in keys}
        self.spent_s.update({key: found[key].wall_s or 0.0 for key in keys})
        return [found[key] for key in keys]

    def _enter(self, known: Shipped, missing: Sequence[Job]) -> None:
        """Enter what comes with the package."""
        found = known.answers(missing, lambda job: self._computed([job])[0])
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
    store: Path, workers: int, progress: Progress, *, anew: bool = False
) -> Iterator[Workers]:
    """Workers that end with the ``with`` block: a diagnosis asks many times, and starts them once.

    With ``anew`` they compute what comes with the package, too.
    """
    where = Where(workers=workers)
    with Pool(where) as pool:
        yield Workers(store, where, progress, pool, None if anew else shipped.read())
