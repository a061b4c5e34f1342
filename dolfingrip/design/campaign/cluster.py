"""Where designs are computed: processes here, a running Dask cluster, or a Slurm cluster."""

from __future__ import annotations

import logging
import os
import signal
import sys
import tomllib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dolfingrip.design.campaign.interrupts import interrupts_answered_by
from dolfingrip.sections.errors import ConfigError

LOST_WORKERS = 2
"""Number of workers that may die on a design before it counts as failed."""

_OF_LOCAL_WORKERS = {
    # Dask gives up a worker that is not back in 15 s, which a cold disk alone can take
    "distributed.deploy.lost-worker-timeout": "1h",
}


@dataclass(frozen=True, slots=True)
class Where:
    """The workers of a campaign; the first that is given counts.

    Attributes:
        scheduler: address of a Dask scheduler.
        slurm: TOML file, see :func:`slurm_settings`.
        workers: number of processes here, or of Slurm jobs.
        ranks: MPI processes of each design.
    """

    scheduler: str | None = None
    slurm: Path | None = None
    workers: int = 1
    ranks: int = 1


@contextmanager
def connected(where: Where) -> Iterator[Any]:
    """A Dask client; workers that were started for it end with it.

    Raises:
        ConfigError: one line, where there is no scheduler or no Slurm, or no worker starts.
    """
    import dask
    from distributed import Client

    # a factorisation holds the interpreter for long, which Dask would take for a dead worker
    settings = {
        "distributed.scheduler.allowed-failures": LOST_WORKERS,
        "distributed.scheduler.worker-ttl": None,
        # where a worker dies, a design that waits on it would count as failed, too
        "distributed.scheduler.worker-saturation": 1.0,
        "distributed.worker.memory.terminate": False,
        "distributed.worker.memory.pause": False,
        "distributed.worker.memory.spill": False,
        "distributed.worker.memory.target": False,
        "distributed.admin.tick.limit": "1h",
    }
    _quiet()
    with dask.config.set(settings), ExitStack() as stack:
        if where.scheduler is not None:
            try:
                client = stack.enter_context(Client(where.scheduler, timeout="20s"))
            except (OSError, ValueError) as error:
                raise ConfigError(f"--scheduler {where.scheduler}: {error}") from None
            yield client
            return
        if where.slurm is not None:
            cluster = _slurm(where)
        else:
            stack.enter_context(dask.config.set(_OF_LOCAL_WORKERS))
            cluster = _local(where)
        yield stack.enter_context(Client(stack.enter_context(cluster)))


def _quiet() -> None:
    """Silence Dask's log of workers and schedulers that die; the store records it."""
    for name in ("tornado.application", *logging.root.manager.loggerDict):
        if name.startswith(("distributed", "tornado")):
            logging.getLogger(name).setLevel(logging.CRITICAL)


def _local(where: Where) -> Any:
    """Processes of their own, one design each at a time: MPI and PETSc are not shared."""
    from distributed import LocalCluster

    from dolfingrip.design.campaign.worker_supervision import WorkerSupervisor

    os.environ["OMP_NUM_THREADS"] = "1"
    try:
        # processes started meanwhile leave Ctrl-C to this one, which ends them
        with interrupts_answered_by(signal.SIG_IGN):
            return LocalCluster(
                n_workers=where.workers,
                threads_per_worker=1,
                worker_class=WorkerSupervisor,
                memory_limit=0,
                dashboard_address="127.0.0.1:0",  # any free port
                silence_logs=logging.CRITICAL,
            )
    except RuntimeError as error:
        reason = error.__cause__ or error
        raise ConfigError(f"--workers {where.workers}: none could be started: {reason}") from None


def _slurm(where: Where) -> Any:
    from dask_jobqueue import SLURMCluster

    assert where.slurm is not None
    settings = slurm_settings(where.slurm, where.ranks)
    try:
        cluster = SLURMCluster(**settings)
        cluster.scale(jobs=where.workers)
    except (OSError, ValueError, TypeError) as error:
        raise ConfigError(f"--slurm {where.slurm}: {error}") from None
    return cluster


def slurm_settings(file: Path, ranks: int) -> dict[str, Any]:
    """Arguments of ``dask_jobqueue.SLURMCluster`` from a TOML file.

    The file holds them by their own names: ``queue``, ``account``, ``walltime``, ``memory``,
    ``job_extra_directives`` and so on. Besides, ``designs_per_job`` (1 by default) is how many
    designs one job computes at a time; processes and processors follow from it and ``ranks``.

    Raises:
        ConfigError: one line, where the file is unreadable or sets an argument that this module
            sets.
    """
    try:
        settings = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"--slurm {file}: {error.strerror}") from None
    except ValueError as error:
        raise ConfigError(f"--slurm {file}: not TOML: {error}") from None
    for key in ("cores", "processes", "job_cpu"):
        if key in settings:
            raise ConfigError(f"--slurm {file}: {key}: allowed: designs_per_job, with --ranks")
    if not isinstance(settings.get("memory"), str):
        raise ConfigError(f'--slurm {file}: memory: allowed: of one job, as in memory = "8GB"')
    at_once = settings.pop("designs_per_job", 1)
    if not isinstance(at_once, int) or isinstance(at_once, bool) or at_once < 1:
        raise ConfigError(f"--slurm {file}: designs_per_job = {at_once}: allowed: at least 1")
    checkout = os.environ.get("DOLFINGRIP_CHECKOUT")
    python = f"{checkout}/scripts/run python" if checkout else sys.executable
    prologue = ["export OMP_NUM_THREADS=1", *settings.pop("job_script_prologue", [])]
    return {
        "python": python,
        "worker_extra_args": ["--no-dashboard"],
        **settings,
        # a thread a process: MPI and PETSc want a process of their own for each design
        "cores": at_once,
        "processes": at_once,
        "job_cpu": at_once * ranks,
        "job_script_prologue": prologue,
    }
