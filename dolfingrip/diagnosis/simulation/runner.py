"""Many jobs on workers, each kept in a store by its content.

What is in the store is not computed again, whichever data asked for it; a diagnosis that is killed
goes on where it was (:mod:`dolfingrip.jobs.run`).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.simulation.job import SHARED, Job, JobResult, calls, result_of
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress, run, silent
from dolfingrip.jobs.store import Store


@dataclass(frozen=True, slots=True)
class Workers:
    """Where simulations are computed and kept.

    Attributes:
        store: folder of the results, made where there is none.
        where: which workers; one MPI process each.
        progress: called with each simulation that is done.
        retry_failed: compute failed simulations anew.
    """

    store: Path
    where: Where = field(default_factory=Where)
    progress: Progress = silent
    retry_failed: bool = False

    def results(self, jobs: Sequence[Job]) -> list[JobResult]:
        """What each of ``jobs`` gave, computed where it is not in the store.

        A simulation that fails has a result, too: its class, a sentence and what was read before.

        Raises:
            ConfigError: one line: no workers, or the store is in use or another's.
            SchedulerGone: the workers are gone; what was computed is kept.
        """
        if self.where.ranks != 1:
            raise ConfigError(f"--ranks {self.where.ranks}: allowed: 1 in a diagnosis")
        keys = [job.key for job in jobs]
        if not keys:
            return []
        with self.pool() as pool:
            run(
                calls(jobs), self.store, pool, SHARED,
                retry_failed=self.retry_failed, progress=self.progress,
            )  # fmt: skip
        with Store(self.store) as store:
            found = {row["key"]: result_of(row) for row in store.rows() if row["key"] in set(keys)}
        return [found[key] for key in keys]

    def pool(self) -> AbstractContextManager[Pool]:
        """The workers that compute what is missing; they end with the ``with`` block."""
        return Pool(self.where)
