"""One folder for all ranks."""

from __future__ import annotations

from pathlib import Path

import pytest
from mpi4py import MPI


@pytest.fixture
def shared(tmp_path: Path) -> Path:
    """Rank 0's temporary folder, on every rank."""
    return Path(MPI.COMM_WORLD.bcast(str(tmp_path)))
