"""One design on a worker: from its configuration to an answer, whatever happens.

Nothing here imports MPI or FEniCSx before the objective does: a worker that hands the design to
``mpirun`` must not be an MPI process itself.
"""

from __future__ import annotations

import importlib
import os
import socket
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from datetime import UTC, datetime
from math import isfinite
from pathlib import Path
from typing import Any

from dolfingrip.design.campaign.answer import Answer, DesignFailure, Outcome
from dolfingrip.design.campaign.spool import Spool
from dolfingrip.sections.errors import ConfigError

Objective = Callable[..., Outcome]
"""From a configuration, the wanted quantities and the number of MPI ranks to their numbers; where
derivatives are asked for, also from the keys of their parameters."""


_ALONE = threading.Lock()
"""MPI and PETSc are a process' own, and the threads of a worker share them."""


@dataclass(frozen=True, slots=True)
class Task:
    """A design as it is sent to a worker.

    Attributes:
        key: of the design.
        config: resolved.
        quantities: outputs that are wanted.
        objective: import path ``module:function`` of an :data:`Objective`.
        ranks: MPI processes that the design runs on.
        spool: folder of the spool; where the worker cannot see it, the answer is only sent.
        gradients: as of a plan.
    """

    key: str
    config: dict[str, Any]
    quantities: tuple[str, ...]
    objective: str
    ranks: int
    spool: str
    gradients: tuple[str, ...] | None = None


def work(task: Task) -> Answer:
    """Compute a design, unless its answer is in the spool, and spool the answer."""
    spool = Spool(Path(task.spool))
    shared = spool.folder.is_dir()
    claim: AbstractContextManager[None] = spool.claimed(task.key) if shared else nullcontext()
    with _ALONE, claim:
        known = spool.read(task.key) if shared else None
        if known is not None:
            return known
        answer = evaluate(task)
        if shared:
            spool.write(answer)
        return answer


def evaluate(task: Task) -> Answer:
    """Compute a design; every failure becomes an answer with its class and a sentence."""
    started, clock = datetime.now(UTC), time.perf_counter()
    answer = Answer(task.key, "failed", started_at=started.isoformat(timespec="milliseconds"))
    answer.worker = f"{socket.gethostname()}:{os.getpid()}"
    try:
        keys = () if task.gradients is None else (task.gradients,)
        outcome = find(task.objective)(task.config, task.quantities, task.ranks, *keys)
        missing = [q for q in task.quantities if not isfinite(outcome.outputs.get(q, float("nan")))]
        if missing:
            raise DesignFailure("no number", f"{', '.join(missing)} came out as no number")
        answer.outputs = {name: float(outcome.outputs[name]) for name in task.quantities}
        answer.gradients, answer.curve = outcome.gradients, outcome.curve
        answer.iterations, answer.versions = outcome.iterations, outcome.versions
        answer.status = "done"
    except DesignFailure as failure:
        answer.failure_class, answer.failure = failure.kind, failure.sentence
        answer.curve = failure.curve
    except ConfigError as error:
        answer.failure_class, answer.failure = "geometry", str(error)
    except MemoryError:
        answer.failure_class, answer.failure = "out of memory", "the worker ran out of memory"
    except Exception as error:  # unattended: recorded in the store, and the next design goes on
        where = traceback.extract_tb(error.__traceback__)[-1]
        answer.failure_class = "error"
        answer.failure = (
            f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
        )
    answer.wall_s = round(time.perf_counter() - clock, 3)
    return answer


def find(path: str) -> Objective:
    """The function at an import path ``module:function``."""
    module, _, name = path.partition(":")
    objective: Objective = getattr(importlib.import_module(module), name)
    return objective
