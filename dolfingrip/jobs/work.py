"""One job on a worker: from its function to an answer, whatever happens.

Nothing here imports MPI or FEniCSx before the function does: a worker that hands the job to
``mpirun`` must not be an MPI process itself.
"""

from __future__ import annotations

import importlib
import os
import socket
import threading
import time
import traceback
from collections.abc import Mapping
from contextlib import nullcontext
from datetime import UTC, datetime
from pathlib import Path
from subprocess import SubprocessError
from typing import Any

from dolfingrip import plugins
from dolfingrip.files.whole import WriteError
from dolfingrip.jobs.interrupts import interrupt_behind
from dolfingrip.jobs.job import ERROR, MACHINE, REFUSED, Job, JobFailure, JobResult, WorkerPolicy
from dolfingrip.jobs.spool import Spool
from dolfingrip.sections.errors import ConfigError, MachineError

_PETSC_OUT_OF_MEMORY = 55
"""``PETSC_ERR_MEM``."""

_ALONE = threading.Lock()
"""MPI and PETSc are a process' own, and the threads of a worker share them."""


def work(job: Job, folder: Path, policy: WorkerPolicy = WorkerPolicy()) -> JobResult:
    """Compute a job, unless its answer is in the spool, and spool the answer.

    A job that the machine does not let come to an end is tried again; its last answer is not
    spooled.

    Args:
        job: which one.
        folder: of the spool; where the worker cannot see it, the answer is only returned.
        policy: how often a job is tried, and the pauses between.

    Returns:
        The answer, with the attempts that broke off.

    Raises:
        WriteError: the job or the spool could not write a file, however often it was tried.
    """
    spool = Spool(folder)
    shared = folder.is_dir()
    with _ALONE:
        broken: list[str] = []
        while True:
            try:
                with spool.claimed(job.key) if shared else nullcontext():
                    answer = (spool.read(job.key) if shared else None) or compute(job)
                    if shared and answer.status != "broken":
                        spool.write(answer)
            except OSError as error:  # of a file, or of the spool's disk
                if isinstance(error, WriteError) and len(broken) + 1 == policy.attempts:
                    raise
                answer = JobResult(job.key, "broken", failure_class=MACHINE, failure=_said(error))
            if answer.status != "broken" or len(broken) + 1 == policy.attempts:
                answer.broken = broken
                return answer
            broken.append(answer.failure or "")
            time.sleep(len(broken) * policy.pause_s)


def compute(job: Job) -> JobResult:
    """Compute a job once; whatever happens becomes an answer with a class and a sentence.

    Args:
        job: which one.

    Returns:
        The answer. It is ``failed`` where the job's function says why it has no result, refuses its
        arguments or has a fault, and ``broken`` where the machine was in the way.

    Raises:
        WriteError: the job could not write a file; it has no answer.
    """
    started, clock = datetime.now(UTC), time.perf_counter()
    answer = JobResult(job.key, "failed", started_at=started.isoformat(timespec="milliseconds"))
    answer.worker = f"{socket.gethostname()}:{os.getpid()}"
    try:
        _take(job.plugins)
        answer.result = found(job.function)(**job.arguments)
        answer.status = "done"
    except JobFailure as failure:
        answer.failure_class, answer.failure = failure.kind, failure.sentence
        answer.partial = failure.partial
    except ConfigError as error:
        answer.failure_class, answer.failure = REFUSED, str(error)
    except WriteError:  # which says nothing about the job
        raise
    except Exception as error:  # unattended: recorded in the store, and the next job goes on
        if interrupt_behind(error):  # which says nothing about the job
            raise KeyboardInterrupt from error
        answer.failure, answer.failure_class = _said(error), ERROR
        if not isinstance(error, MachineError):
            where = traceback.extract_tb(error.__traceback__)[-1]
            answer.failure += f" ({Path(where.filename).name}:{where.lineno})"
        if of_machine(error):
            answer.status, answer.failure_class = "broken", MACHINE
    answer.wall_s = round(time.perf_counter() - clock, 3)
    return answer


def _take(files: Mapping[str, str]) -> None:
    """Take the plugins of whoever asks for a job.

    Args:
        files: digests by path.

    Raises:
        MachineError: one line, where this worker cannot have them.
    """
    try:
        for file in files:
            plugins.add(file)
        different = files.items() - plugins.digests_of_files().items()
    except (OSError, plugins.PluginError) as error:
        raise MachineError(str(error)) from None
    for file, _ in different:
        raise MachineError(f"--plugin {file}: changed since; allowed: the same command, anew")


def of_machine(error: BaseException | None) -> bool:
    """Return whether memory, a disk, a compiler or a process that died is behind an error."""
    while error is not None:
        if isinstance(error, MachineError | MemoryError | OSError | SubprocessError):
            return True
        if getattr(error, "ierr", None) == _PETSC_OUT_OF_MEMORY:
            return True
        error = error.__cause__ or error.__context__
    return False


def _said(error: BaseException) -> str:
    """An error in one line, without the class where that says nothing."""
    if isinstance(error, MachineError | WriteError):
        return str(error)
    if isinstance(error, MemoryError):
        return "the worker ran out of memory"
    return f"{type(error).__name__}: {error}"


def found(path: str) -> Any:
    """The function at an import path ``module:function``.

    Args:
        path: import path of the function, ``module:name``.

    Returns:
        The function.
    """
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)
