"""Workers that are started once they have something to do."""

from __future__ import annotations

import logging
from collections.abc import Generator, Sequence
from contextlib import ExitStack
from queue import SimpleQueue
from typing import Any

from dolfingrip.files.whole import WriteError
from dolfingrip.jobs.cluster import Where, connected
from dolfingrip.jobs.interrupts import interrupts_answered_by
from dolfingrip.jobs.job import MACHINE, Job, JobResult
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.work import work

_LOG = logging.getLogger(__name__)

_INTERRUPT = object()  # what Ctrl-C puts among the answers


class Unfinished(Exception):
    """Not all jobs could be computed, as the text says; what was computed is kept."""


class SchedulerGone(Unfinished):
    """The scheduler ended before the jobs."""


class Pool:
    """Workers that start with the first job and end with the ``with`` block.

    Without Dask this process computes the jobs itself, where one process is asked for.

    Args:
        where: which workers.

    Raises:
        ModuleNotFoundError: the workers need Dask, which is not installed.
    """

    def __init__(self, where: Where) -> None:
        self.where = where
        self._here = where.without_dask
        self._stack = ExitStack()
        self._client: Any = None

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *ending: Any) -> None:
        self._client = None
        try:
            self._stack.__exit__(*ending)
        except Exception as closing:  # all answers are kept by now
            _LOG.warning("workers did not close: %s: %s", type(closing).__name__, closing)

    def answers(self, jobs: Sequence[Job], spool: Spool) -> Generator[JobResult]:
        """Compute jobs.

        Args:
            jobs: which ones.
            spool: keeps answers; that of a job that the machine did not let come to an end is
                ``broken`` and not kept.

        Yields:
            Answers in the order of completion; each job has one, however it ends.

        Raises:
            ConfigError: one line, where there are no workers.
            SchedulerGone: all workers are gone.
            WriteError: a worker could not write a file.
            KeyboardInterrupt: Ctrl-C, which waits until the next answer is asked for.
        """
        if not jobs:
            return
        if self._here:
            yield from (work(job, spool.folder) for job in jobs)
            return
        if self._client is None:
            self._client = self._stack.enter_context(connected(self.where))
        # An interrupt is one more item of the queue: raised wherever the signal comes, it can end
        # up in a destructor, which swallows it, and the jobs would go on.
        arrived: SimpleQueue[Any] = SimpleQueue()
        with interrupts_answered_by(lambda number, frame: arrived.put(_INTERRUPT)):
            keys = {}
            for job in jobs:
                # Dask's key is the job's: a scheduler that still computes it takes up that
                future = self._client.submit(work, job, spool.folder, key=f"job-{job.key}")
                keys[future] = job.key
                future.add_done_callback(arrived.put)
            # each is dropped as it is stored
            while keys:
                future = arrived.get()
                if future is _INTERRUPT:
                    raise KeyboardInterrupt
                answer = _answer(future, keys[future], spool)
                if answer is None:
                    future.add_done_callback(arrived.put)
                    continue
                del keys[future]
                yield answer


def _answer(future: Any, key: str, spool: Spool) -> JobResult | None:
    """The answer behind a future that has ended; None where it is computed again.

    Raises:
        SchedulerGone: which says nothing about the job.
        WriteError: likewise.
    """
    from distributed import KilledWorker
    from distributed.client import FutureCancelledError

    # What is on the disk outlives the worker that computed it and Dask's copy with it.
    spooled = spool.read(key)
    if spooled is not None:
        return spooled
    if future.status in ("lost", "pending"):  # its worker died since, and another takes it up
        return None
    try:
        error = future.exception() if future.status == "error" else None
        if error is None:
            answer: JobResult = future.result()
            return answer
    except FutureCancelledError:
        raise SchedulerGone(
            "the scheduler is gone; what was computed is kept, the same call goes on from there"
        ) from None
    if isinstance(error, WriteError):
        raise error
    said = f"{type(error).__name__}: {error}"
    if isinstance(error, KilledWorker):
        said = "every worker that computed it died, for want of memory or by a crash"
    return JobResult(key, "broken", failure_class=MACHINE, failure=said)
