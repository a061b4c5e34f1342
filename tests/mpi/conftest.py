"""One folder for all ranks, and what runs on two of them alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from mpi4py import MPI
from support import stored

RANKS = MPI.COMM_WORLD.size


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what would find the stored readings again on one rank or on three.

    One rank has found them, and other tests look at what is computed without MPI. With three ranks
    one is neither the first nor the last, which each kind of communication meets in another test.
    """
    if item.get_closest_marker("two_ranks") and RANKS != 2 and not stored.WRITES:
        pytest.skip("two ranks: scripts/run mpirun -n 2 python -m pytest tests/mpi")


@pytest.fixture
def shared(tmp_path: Path) -> Path:
    """Rank 0's temporary folder, on every rank."""
    return Path(MPI.COMM_WORLD.bcast(str(tmp_path)))
