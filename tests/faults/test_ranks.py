"""Ranks that are killed while they compute: the simulation is made again, and nothing is lost.

The reference is the same simulation on ranks that live.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.ranks import killed_ranks
from support.small import short
from support.this_process import ThisProcess

from dolfingrip.experiments.request import Request
from dolfingrip.experiments.simulate import simulate
from dolfingrip.jobs.job import WorkerPolicy
from dolfingrip.jobs.pool import Unfinished
from dolfingrip.jobs.store import Store

CONFIG = short("experiment.max_pressure_kPa=10", "experiment.step_kPa=10")


@pytest.mark.slow
def test_a_rank_that_is_killed(tmp_path: Path) -> None:
    (expected,) = simulate([Request.of("bending", CONFIG)], tmp_path / "alone", ThisProcess())
    request = Request.of("bending", CONFIG, ranks=2)
    with killed_ranks(lambda before: 0.5 if before == 0 else None) as killed:
        (answer,) = simulate([request], tmp_path / "ranks", ThisProcess())
    assert len(killed) == 1
    assert answer.failure_class is None
    found = answer.columns["angle_deg"]
    np.testing.assert_allclose(found, expected.columns["angle_deg"], rtol=1e-5)


def test_ranks_that_are_killed_however_often(tmp_path: Path) -> None:
    request = Request.of("bending", CONFIG, ranks=2)
    who = "(rank [01]|a rank)"  # MPICH tells no number
    said = rf"^1 of 1 could not be computed .*: {who} was ended by signal 9 \(SIGKILL\); mostly"
    with (
        killed_ranks(lambda before: 0.0) as killed,
        pytest.raises(Unfinished, match=said) as ended,
    ):
        simulate([request], tmp_path, ThisProcess())
    assert "\n" not in str(ended.value)
    assert len(killed) == WorkerPolicy().attempts
    with Store(tmp_path) as store:
        assert [row["status"] for row in store.rows()] == ["pending"]
