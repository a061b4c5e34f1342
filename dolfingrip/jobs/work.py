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
from contextlib import AbstractContextManager, nullcontext
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from dolfingrip.files.whole import WriteError
from dolfingrip.jobs.interrupts import interrupt_behind
from dolfingrip.jobs.job import MACHINE, REFUSED, Answer, Job, JobFailure
from dolfingrip.jobs.spool import Spool
from dolfingrip.sections.errors import ConfigError, MachineError

_ALONE = threading.Lock()
"""MPI and PETSc are a process' own, and the threads of a worker share them."""


def work(job: Job, folder: Path) -> Answer:
    """Compute a job, unless its answer is in the spool, and spool the answer.

    Args:
        job: which one.
        folder: of the spool; where the worker cannot see it, the answer is only returned.

    Returns:
        The answer, also that of a job that failed.

    Raises:
        WriteError: the job or the spool could not write a file; the job has no answer.
    """
    spool = Spool(folder)
    shared = folder.is_dir()
    claim: AbstractContextManager[None] = spool.claimed(job.key) if shared else nullcontext()
    with _ALONE, claim:
        known = spool.read(job.key) if shared else None
        if known is not None:
            return known
        answer = compute(job)
        if shared:
            spool.write(answer)
        return answer


def compute(job: Job) -> Answer:
    """Compute a job; every failure of its own becomes an answer with its class and a sentence."""
    started, clock = datetime.now(UTC), time.perf_counter()
    answer = Answer(job.key, "failed", started_at=started.isoformat(timespec="milliseconds"))
    answer.worker = f"{socket.gethostname()}:{os.getpid()}"
    try:
        answer.result = found(job.function)(**job.arguments)
        answer.status = "done"
    except JobFailure as failure:
        answer.failure_class, answer.failure = failure.kind, failure.sentence
        answer.partial = failure.partial
    except ConfigError as error:
        answer.failure_class, answer.failure = REFUSED, str(error)
    except WriteError:  # which says nothing about the job
        raise
    except MachineError as error:
        answer.failure_class, answer.failure = MACHINE, str(error)
    except MemoryError:
        answer.failure_class, answer.failure = "out of memory", "the worker ran out of memory"
    except Exception as error:  # unattended: recorded in the store, and the next job goes on
        if interrupt_behind(error):  # which says nothing about the job
            raise KeyboardInterrupt from error
        where = traceback.extract_tb(error.__traceback__)[-1]
        answer.failure_class = "error"
        answer.failure = (
            f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
        )
    answer.wall_s = round(time.perf_counter() - clock, 3)
    return answer


def found(path: str) -> Any:
    """The function at an import path ``module:function``."""
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)
