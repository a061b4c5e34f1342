"""Workers as Slurm jobs."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any, Final

from dolfingrip.jobs import connections
from dolfingrip.sections import tables
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.private import cache_folder

_OURS: Final = {
    **dict.fromkeys(("cores", "processes", "job_cpu"), "designs_per_job, with --ranks"),
    **dict.fromkeys(("protocol", "security"), "TLS, with keys made for each cluster"),
}
"""Arguments that this module sets, and what is allowed in their place."""

_PRIVATE: Final = [
    # Dask imports from there; its own choice in /tmp is one that another user may have made
    'export DASK_TEMPORARY_DIRECTORY="$(mktemp -d)"',
    """trap 'rm -rf "$DASK_TEMPORARY_DIRECTORY"' EXIT""",
    "export DASK_DISTRIBUTED__WORKER__HTTP__ROUTES='[]'",
    "export PYTHONSAFEPATH=1",  # no modules of the folder that the command was called in
    # a connection that breaks is an error of Python then, not a crash
    f"export DASK_DISTRIBUTED__WORKER__PRELOAD='{json.dumps(connections.PRELOAD)}'",
    f"export DASK_DISTRIBUTED__NANNY__PRELOAD='{json.dumps(connections.PRELOAD)}'",
    'export PETSC_OPTIONS="-no_signal_handler ${PETSC_OPTIONS:-}"',
]
"""What keeps other users of a node out of its workers, beside their keys, and suits TLS."""


def cluster(file: Path, workers: int, ranks: int, security: Any) -> Any:
    """Workers as Slurm jobs, as a Dask cluster.

    Args:
        file: TOML of the settings.
        workers: number of Slurm jobs.
        ranks: MPI processes of each of our jobs.
        security: Dask's ``Security`` with keys of this cluster. Workers find theirs in files that
            nobody else may read, in a folder of the cache, as long as the cluster is there.

    Raises:
        ConfigError: one line, where there is no Slurm, or it refuses the settings.
    """
    from dask_jobqueue import SLURMCluster

    arguments = {  # the first two are no part of a job's, unless the file has others
        "scheduler_options": {"dashboard": False, "dashboard_address": "127.0.0.1:0"},
        "shared_temp_directory": str(cache_folder("dolfingrip", "keys")),
        **settings(file, ranks),
    }
    try:
        started = SLURMCluster(**arguments, security=security)
        started.scale(jobs=workers)
    except (OSError, ValueError, TypeError) as error:
        raise ConfigError(f"--slurm {file}: {error}") from None
    return started


def settings(file: Path, ranks: int) -> dict[str, Any]:
    """Arguments of ``dask_jobqueue.SLURMCluster`` from a TOML file.

    The file holds them by their own names: ``queue``, ``account``, ``walltime``, ``memory``,
    ``job_extra_directives`` and so on. Besides, ``designs_per_job`` (1 by default) is how many
    designs one job computes at a time; processes and processors follow from it and ``ranks``.

    Raises:
        ConfigError: one line, where the file is unreadable or sets an argument that this module
            sets.
    """
    arguments = tables.whole(file, "--slurm")
    options = arguments.get("scheduler_options", {})
    if not isinstance(options, dict):
        raise ConfigError(f"--slurm {file}: scheduler_options: allowed: a table")
    for key, allowed in _OURS.items():
        if key in {**arguments, **options}:
            raise ConfigError(f"--slurm {file}: {key}: allowed: {allowed}")
    if not isinstance(arguments.get("memory"), str):
        raise ConfigError(f'--slurm {file}: memory: allowed: of one job, as in memory = "8GB"')
    at_once = arguments.pop("designs_per_job", 1)
    if not isinstance(at_once, int) or isinstance(at_once, bool) or at_once < 1:
        raise ConfigError(f"--slurm {file}: designs_per_job = {at_once}: allowed: at least 1")
    checkout = os.environ.get("DOLFINGRIP_CHECKOUT")
    python = f"{checkout}/scripts/run python" if checkout else sys.executable
    prologue = [*_PRIVATE, "export OMP_NUM_THREADS=1", *arguments.pop("job_script_prologue", [])]
    return {
        "python": python,
        "worker_extra_args": ["--no-dashboard"],
        **arguments,
        # a thread a process: MPI and PETSc want a process of their own for each design
        "cores": at_once,
        "processes": at_once,
        "job_cpu": at_once * ranks,
        "job_script_prologue": prologue,
    }
