"""Workers as Slurm jobs."""

from __future__ import annotations

import os
import sys
import tomllib
from pathlib import Path
from typing import Any

from dolfingrip.sections.errors import ConfigError


def cluster(file: Path, workers: int, ranks: int) -> Any:
    """Workers as Slurm jobs, as a Dask cluster.

    Args:
        file: TOML of the settings.
        workers: number of Slurm jobs.
        ranks: MPI processes of each of our jobs.

    Raises:
        ConfigError: one line, where there is no Slurm, or it refuses the settings.
    """
    from dask_jobqueue import SLURMCluster

    arguments = settings(file, ranks)
    try:
        started = SLURMCluster(**arguments)
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
    try:
        found = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"--slurm {file}: {error.strerror}") from None
    except ValueError as error:
        raise ConfigError(f"--slurm {file}: not TOML: {error}") from None
    for key in ("cores", "processes", "job_cpu"):
        if key in found:
            raise ConfigError(f"--slurm {file}: {key}: allowed: designs_per_job, with --ranks")
    if not isinstance(found.get("memory"), str):
        raise ConfigError(f'--slurm {file}: memory: allowed: of one job, as in memory = "8GB"')
    at_once = found.pop("designs_per_job", 1)
    if not isinstance(at_once, int) or isinstance(at_once, bool) or at_once < 1:
        raise ConfigError(f"--slurm {file}: designs_per_job = {at_once}: allowed: at least 1")
    checkout = os.environ.get("DOLFINGRIP_CHECKOUT")
    python = f"{checkout}/scripts/run python" if checkout else sys.executable
    prologue = ["export OMP_NUM_THREADS=1", *found.pop("job_script_prologue", [])]
    return {
        "python": python,
        "worker_extra_args": ["--no-dashboard"],
        **found,
        # a thread a process: MPI and PETSc want a process of their own for each design
        "cores": at_once,
        "processes": at_once,
        "job_cpu": at_once * ranks,
        "job_script_prologue": prologue,
    }
