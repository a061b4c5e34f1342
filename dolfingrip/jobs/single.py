"""One worker process that computes one job at a time, while somebody waits for the answer.

A newer job takes the place of an older one, which gives up where it next tells its progress; its
worker is ended where it does not come to that in time, and begun anew. Answers are spooled as those
of all jobs are, so a job that was computed once is answered at once, also after a restart.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Final

from dolfingrip.files.whole import WriteError
from dolfingrip.jobs.job import MACHINE, Job, JobResult
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.work import found, work

Hear = Callable[[str, int, int, str], None]
"""Told of progress: key of the job, number done, number of all, a note."""

_EXPECTED: Final = 3.0
"""Seconds that a worker which was told to end may take."""

_PATIENCE: Final = 3.0
"""Seconds that a job may take to give up; a worker that is begun anew takes as long to be ready."""


class Superseded(BaseException):
    """Another job takes the place of this one; no ``Exception``, as no job may catch it."""


_key = ""
"""Of the job that this process computes, if it is a worker."""

_told: Connection | None = None
"""Where this process, if it is a worker, tells how far its job is."""

_last: tuple[Any, ...] = ()
"""What it told last."""


def tell(done: int, total: int, note: str = "") -> None:
    """Say how far the present job is, or leave it; nothing happens outside of such a worker.

    Args:
        done: steps of the job that are done.
        total: all steps.
        note: what is told beside.
    """
    global _last
    if _told is None:
        return
    # a form is compiled beside a thread that tells of it
    if threading.current_thread() is threading.main_thread() and _told.poll():
        raise Superseded
    message = ("progress", _key, done, total, note)
    if message != _last:
        _last = message
        _told.send(message)


class Single:
    """A worker of one job.

    Args:
        spool: folder of answers.
        hear: told of progress, from a thread of its own.
        done: told of answers, from the same thread.
        first: import path of a function without arguments that a worker calls before its jobs, such
            as one that loads what they need; "": none.
    """

    def __init__(
        self, spool: Path, hear: Hear, done: Callable[[JobResult], None], first: str = ""
    ) -> None:
        self._spool, self._first = Spool(spool), first
        self._hear, self._done = hear, done
        self._lock = threading.Lock()
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None
        self._job: Job | None = None
        self._begun = ""  # key of the job that the worker began last

    @property
    def job(self) -> Job | None:
        """The job that is computed; None if there is none."""
        return self._job

    def known(self, key: str) -> JobResult | None:
        """The answer of a job that was computed before."""
        return self._spool.read(key)

    def forget(self, key: str) -> None:
        """Compute a job anew when it is asked for the next time."""
        self._spool.forget(key)

    def begin(self) -> None:
        """Start the worker, so that it is ready when the first job comes."""
        with self._lock:
            if self._process is None:
                self._begin()

    def ask(self, job: Job) -> None:
        """Compute a job in place of the present one, if that is another."""
        with self._lock:
            if self._job is not None and self._job.key == job.key:
                return
            self._turn_to(job)

    def cancel(self) -> None:
        """Give up the present job."""
        with self._lock:
            if self._job is not None:
                self._turn_to(None)

    def _turn_to(self, job: Job | None) -> None:
        """Have the worker leave the present job, if there is one, for another, or for none."""
        busy = self._job is not None
        self._job = job
        if self._process is None or not self._process.is_alive():
            self._begin()
        assert self._connection is not None
        with suppress(OSError):  # a worker that died: its listener answers
            self._connection.send(job)
        if busy:
            threading.Timer(_PATIENCE, self._insist, (self._process, job)).start()

    def _insist(self, process: BaseProcess | None, job: Job | None) -> None:
        """Begin a worker anew that has not turned to a job, or to none."""
        with self._lock:
            turned = self._begun == ("" if job is None else job.key)
            if turned or self._process is not process or self._job is not job:
                return
            self._end()
            if job is not None:
                self._turn_to(job)

    def close(self) -> None:
        """End the worker."""
        with self._lock:
            self._end()

    def _begin(self) -> None:
        self._spool.folder.mkdir(parents=True, exist_ok=True)
        # a fresh interpreter: MPI and PETSc do not outlive a fork
        context = get_context("spawn")
        self._begun = ""
        self._connection, theirs = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(theirs, self._spool.folder, self._first), daemon=True
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
            process.join()

    def _listen(self, connection: Connection, process: BaseProcess) -> None:
        while True:
            try:
                kind, key, *details = connection.recv()
            except (EOFError, OSError):
                self._lost(process)
                return
            with self._lock:
                if kind == "begun" and self._process is process:
                    self._begun = key
                job = self._job if self._process is process else None
                if job is None or job.key != key:  # another one has taken its place
                    continue
                if kind == "answer":
                    self._job = None
            if kind == "answer":
                self._done(details[0])
            elif kind == "progress":
                self._hear(key, *details)

    def _lost(self, process: BaseProcess) -> None:
        """Record the end of a worker that died of itself."""
        with self._lock:
            job = self._job if self._process is process else None
            if job is None:
                return
            self._process = self._job = None
        self._done(
            JobResult(
                job.key, "broken", failure_class=MACHINE,
                failure="the process that computed it died, for want of memory or by a crash",
            )
        )  # fmt: skip


def _serve(connection: Connection, spool: Path, first: str) -> None:
    """Compute jobs as they come, until the other side is gone."""
    global _key, _told
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the other side's
    os.environ["OMP_NUM_THREADS"] = "1"
    _told = connection
    if first:
        found(first)()
    while True:
        try:
            job: Any = connection.recv()
            _key = "" if job is None else job.key
            connection.send(("begun", _key))
            if job is None:
                continue
            try:
                answer = work(job, spool)
            except Superseded:
                continue
            except WriteError as error:
                answer = JobResult(job.key, "broken", failure_class=MACHINE, failure=str(error))
            connection.send(("answer", job.key, answer))
        except (EOFError, OSError):
            return
