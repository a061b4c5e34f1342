"""One worker process that computes one job at a time, while somebody waits for the answer.

A newer job takes the place of an older one, whose worker is ended. Answers are spooled as those of
all jobs are, so a job that was computed once is answered at once, also after a restart.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Final

from dolfingrip.files.whole import WriteError
from dolfingrip.jobs.job import MACHINE, Answer, Job
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.work import work

Hear = Callable[[str, int, int, str], None]
"""Told of progress: key of the job, number done, number of all, a note."""

_EXPECTED: Final = 3.0
"""Seconds that a worker which was told to end may take."""

_told: Connection | None = None
"""Where this process, if it is a worker, tells how far its job is."""


def tell(done: int, total: int, note: str = "") -> None:
    """Say how far the present job is; nothing happens outside of such a worker.

    Args:
        done: steps of the job that are done.
        total: all steps.
        note: what is told beside.
    """
    if _told is not None:
        _told.send(("progress", done, total, note))


class Single:
    """A worker of one job.

    Args:
        spool: folder of answers.
        hear: told of progress, from a thread of its own.
        done: told of answers, from the same thread.
    """

    def __init__(self, spool: Path, hear: Hear, done: Callable[[Answer], None]) -> None:
        self._spool = Spool(spool)
        self._hear, self._done = hear, done
        self._lock = threading.Lock()
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None
        self._job: Job | None = None

    @property
    def job(self) -> Job | None:
        """The job that is computed; None if there is none."""
        return self._job

    def known(self, key: str) -> Answer | None:
        """The answer of a job that was computed before."""
        return self._spool.read(key)

    def forget(self, key: str) -> None:
        """Compute a job anew when it is asked for the next time."""
        self._spool.forget(key)

    def ask(self, job: Job) -> None:
        """Compute a job in place of the present one, if that is another."""
        with self._lock:
            if self._job is not None:
                if self._job.key == job.key:
                    return
                self._end()
            if self._process is None or not self._process.is_alive():
                self._begin()
            assert self._connection is not None
            self._job = job
            self._connection.send(job)

    def cancel(self) -> None:
        """Give up the present job."""
        with self._lock:
            if self._job is not None:
                self._end()

    def close(self) -> None:
        """End the worker."""
        with self._lock:
            self._end()

    def _begin(self) -> None:
        self._spool.folder.mkdir(parents=True, exist_ok=True)
        # a fresh interpreter: MPI and PETSc do not outlive a fork
        context = get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(theirs, self._spool.folder), daemon=True
        )
        self._process.start()
        theirs.close()
        listen = threading.Thread(
            target=self._listen, args=(self._connection, self._process), daemon=True
        )
        listen.start()

    def _end(self) -> None:
        process, self._process, self._job = self._process, None, None
        if process is None:
            return
        process.terminate()
        process.join(_EXPECTED)
        if process.is_alive():  # inside a factorisation, say
            process.kill()

    def _listen(self, connection: Connection, process: BaseProcess) -> None:
        while True:
            try:
                kind, *rest = connection.recv()
            except (EOFError, OSError):
                self._lost(process)
                return
            with self._lock:
                job = self._job if self._process is process else None
                if job is not None and kind == "answer":
                    self._job = None
            if job is None:  # another one has taken its place
                continue
            if kind == "answer":
                self._done(rest[0])
            else:
                self._hear(job.key, *rest)

    def _lost(self, process: BaseProcess) -> None:
        """Answer for a worker that died of itself."""
        with self._lock:
            job = self._job if self._process is process else None
            if job is None:
                return
            self._process = self._job = None
        self._done(
            Answer(
                job.key, "broken", failure_class=MACHINE,
                failure="the process that computed it died, for want of memory or by a crash",
            )
        )  # fmt: skip


def _serve(connection: Connection, spool: Path) -> None:
    """Compute jobs as they come, until the other side is gone."""
    global _told
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the other side's
    os.environ["OMP_NUM_THREADS"] = "1"
    _told = connection
    while True:
        try:
            job: Any = connection.recv()
            try:
                answer = work(job, spool)
            except WriteError as error:
                answer = Answer(job.key, "broken", failure_class=MACHINE, failure=str(error))
            connection.send(("answer", answer))
        except (EOFError, OSError):
            return
