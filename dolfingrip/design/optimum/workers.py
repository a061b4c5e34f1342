"""Processes that take jobs one at a time: JSON lines in, JSON lines out.

Plain processes of a module, rather than :mod:`multiprocessing`, whose children either copy a
process that MPI runs in or start it again, and wait for ever where their parent is killed. These
end by themselves as soon as their input does.
"""

from __future__ import annotations

import json
import selectors
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from typing import IO, Any

Job = dict[str, Any]


class WorkerDied(RuntimeError):
    """A process ended before its job did; the message ends with the last line it wrote."""


def serve(work: Callable[[Job], Job]) -> None:
    """What a worker's process does: each line in is a job, each line out its result."""
    for line in sys.stdin:
        sys.stdout.write(json.dumps(work(json.loads(line))) + "\n")
        sys.stdout.flush()


def run(module: str, jobs: Iterable[Job], processes: int) -> Iterator[tuple[Job, Job]]:
    """Do jobs in several processes.

    Args:
        module: run as ``python -m``; it calls :func:`serve`.
        jobs: JSON-serialisable.
        processes: how many at a time, one core each.

    Yields:
        Each job with its result, as they come.

    Raises:
        WorkerDied: a process ended early. What was yielded before stands.
    """
    waiting = iter(jobs)
    with tempfile.TemporaryFile("w+") as errors, selectors.DefaultSelector() as ready:
        started: list[subprocess.Popen[str]] = []
        try:
            for job in _first(waiting, processes):
                worker = _start(module, errors)
                started.append(worker)
                ready.register(_pipe(worker.stdout), selectors.EVENT_READ, (worker, job))
                _send(worker, job)
            while ready.get_map():
                for key, _ in ready.select():
                    worker, job = key.data
                    line = _pipe(worker.stdout).readline()
                    if not line:
                        raise WorkerDied(_last_words(worker, errors))
                    ready.unregister(key.fileobj)
                    following = next(waiting, None)
                    if following is not None:
                        ready.register(key.fileobj, selectors.EVENT_READ, (worker, following))
                        _send(worker, following)
                    yield job, json.loads(line)
        finally:
            for worker in started:
                worker.terminate()
            for worker in started:
                worker.communicate()


def _first(jobs: Iterator[Job], count: int) -> Iterator[Job]:
    for _, job in zip(range(count), jobs, strict=False):
        yield job


def _start(module: str, errors: IO[str]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-P", "-m", module],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=errors,
        text=True,
        start_new_session=True,  # Ctrl-C reaches the parent alone, which ends these
    )


def _pipe(stream: IO[str] | None) -> IO[str]:
    assert stream is not None
    return stream


def _send(worker: subprocess.Popen[str], job: Job) -> None:
    stream = _pipe(worker.stdin)
    try:
        stream.write(json.dumps(job) + "\n")
        stream.flush()
    except BrokenPipeError:  # it has died: reported where its answer is read
        pass


def _last_words(worker: subprocess.Popen[str], errors: IO[str]) -> str:
    code = worker.wait()
    errors.seek(0)
    lines = errors.read().strip().splitlines()
    return f"a worker ended with code {code}: {lines[-1] if lines else 'no message'}"
