"""``examples/mpi.py`` on any number of ranks: its angle is what one rank found."""

from __future__ import annotations

import pytest
from mpi4py import MPI
from support.example import load

pytestmark = pytest.mark.two_ranks

ONE_RANK_deg = 6.958811581


def test_the_example_has_the_same_answer() -> None:
    angle = load("mpi").main(MPI.COMM_WORLD)
    assert angle == pytest.approx(ONE_RANK_deg, rel=1e-8)
    assert MPI.COMM_WORLD.allgather(angle) == [angle] * MPI.COMM_WORLD.size
