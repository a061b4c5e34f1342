"""The number of workers behind `-n auto` in pyproject.toml, and how forms are compiled."""

from __future__ import annotations

import importlib.metadata
import os
from functools import cache

import pytest

# in a fourth of level 3's time; subprocesses inherit it, and it stands before any import of the
# package, which reads it then
os.environ.setdefault("DOLFINGRIP_OPTIMISATION", "1")

# setuptools, by which CFFI calls the compiler, reads the entry points of all packages six times for
# each form: as long as the analysis of a small one takes
importlib.metadata.entry_points = cache(importlib.metadata.entry_points)

MOST = 4
"""Workers on machines of many cores: each takes 1 GB, and some tests start more processes."""


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """One worker a core; none on a single core, for tests that are named, and under mpirun.

    Tests without workers print as they go, and take breakpoints. Under mpirun each rank is one
    pytest, and all must run the same tests in the same order.
    """
    by_name = all("::" in argument for argument in config.args)
    cores = len(os.sched_getaffinity(0))
    if by_name or cores == 1 or "OMPI_COMM_WORLD_SIZE" in os.environ:
        return 0
    return min(cores, MOST)
