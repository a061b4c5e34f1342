"""Where jobs are computed: processes here, a running Dask cluster, or a Slurm cluster."""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from dolfingrip.jobs import connections, slurm
from dolfingrip.jobs.interrupts import interrupts_answered_by
from dolfingrip.jobs.job import WorkerPolicy
from dolfingrip.sections.errors import ConfigError

_EVERYWHERE: dict[str, Any] = {
    "distributed.scheduler.worker-ttl": None,
    # where a worker dies, a job that waits on it would count as failed, too
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.worker.memory.terminate": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.target": False,
    # samples of the call stack, which a worker keeps: half a MB for each second
    "distributed.worker.profile.enabled": False,
    # pages of the jobs for everybody who asks
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.worker.preload": connections.PRELOAD,
}


@dataclass(frozen=True, slots=True)
class Where:
    """The workers of jobs; the first that is given counts.

    Attributes:
        scheduler: address of a Dask scheduler, whose keys are those of Dask's configuration.
        slurm: TOML file, see :func:`dolfingrip.jobs.slurm.settings`.
        workers: number of processes here, or of Slurm jobs.
        ranks: MPI processes of each job.
    """

    scheduler: str | None = None
    slurm: Path | None = None
    workers: int = 1
    ranks: int = 1

    @property
    def without_dask(self) -> bool:
        """True where Dask is not installed and one process here is asked for, which can do without.

        Raises:
            ModuleNotFoundError: Dask is not installed and the workers need it.
        """
        if find_spec("distributed"):
            return False
        if self.scheduler or self.slurm or self.workers > 1 or self.ranks > 1:
            raise ModuleNotFoundError(name="distributed")
        return True


@contextmanager
def connected(where: Where, policy: WorkerPolicy = WorkerPolicy()) -> Iterator[Any]:
    """Connect a Dask client; workers that were started for it end with it.

    Args:
        where: the workers.
        policy: when they are given up.

    Yields:
        The client.

    Raises:
        ConfigError: one line, where there is no scheduler or no Slurm, or no worker starts.
    """
    import dask
    from distributed import Client

    for name in ("tornado.application", *logging.root.manager.loggerDict):
        if name.startswith(("distributed", "tornado")):  # the store records workers that die
            logging.getLogger(name).setLevel(logging.CRITICAL)
    with connections.broken_connections_are_errors(), ExitStack() as stack:
        # Dask imports from there; its own choice in /tmp is one that another user may have made
        scratch = stack.enter_context(
            TemporaryDirectory(prefix="dolfingrip-", ignore_cleanup_errors=True)
        )
        silence = f"{policy.silence_h:g}h"
        settings = {
            **_EVERYWHERE,
            "distributed.scheduler.allowed-failures": policy.lost_workers,
            "distributed.admin.tick.limit": silence,
            "temporary-directory": scratch,
        }
        stack.enter_context(dask.config.set(settings))
        if where.scheduler is not None:
            yield stack.enter_context(_running(where.scheduler, policy))
            return
        security = connections.fresh_keys()
        if where.slurm is not None:
            cluster = slurm.cluster(where.slurm, where.workers, where.ranks, security)
        else:
            stack.enter_context(
                dask.config.set({"distributed.deploy.lost-worker-timeout": silence})
            )
            cluster = _local(where, security, policy)
        yield stack.enter_context(Client(stack.enter_context(cluster)))


def _running(address: str, policy: WorkerPolicy) -> Any:
    """A client of a scheduler that is there."""
    from distributed import Client

    if not address.startswith(("tls://", "inproc://")):
        raise ConfigError(
            f"--scheduler {address}: whoever reaches it could run code as you; "
            "allowed: tls://HOST:PORT, see docs/cluster.md"
        )
    try:
        return Client(address, timeout=f"{policy.connect_s:g}s")
    except TypeError:  # Dask's own for want of a certificate
        raise ConfigError(
            f"--scheduler {address}: no certificate; allowed: with one in Dask's configuration, "
            "see docs/cluster.md"
        ) from None
    except (OSError, ValueError) as error:
        raise ConfigError(f"--scheduler {address}: {error}") from None


def _local(where: Where, security: Any, policy: WorkerPolicy) -> Any:
    """Processes of their own, one job each at a time: MPI and PETSc are not shared."""
    from distributed import LocalCluster

    from dolfingrip.jobs.supervision import WorkerSupervisor

    os.environ["OMP_NUM_THREADS"] = "1"
    try:
        # processes started meanwhile leave Ctrl-C to this one, which ends them
        with interrupts_answered_by(signal.SIG_IGN):
            return LocalCluster(
                n_workers=where.workers,
                threads_per_worker=1,
                worker_class=WorkerSupervisor,
                policy=policy,
                memory_limit=0,
                security=security,
                dashboard_address="127.0.0.1:0",  # any free port, with no page
                scheduler_kwargs={"dashboard": False},
                silence_logs=logging.CRITICAL,
            )
    except (RuntimeError, OSError) as error:
        first: BaseException = error
        if isinstance(error, OSError) and error.__context__ is not None:
            first = error.__context__  # closing failed in its turn, over TLS
        reason = first.__cause__ or first
        raise ConfigError(f"--workers {where.workers}: none could be started: {reason}") from None
