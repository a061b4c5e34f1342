"""Times of records of bodies that move: standing time, gaps, rows too far apart for the swing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from support.measured_files import written

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.simulation.aliasing import aliased, undersampled
from dolfingrip.experiments.request import Request

MOVING = Config().changed(experiment={"dynamic": True})


def record(folder: Path, times_s: Sequence[float], config: Config = MOVING) -> Measurement:
    """A pressure that jumps at the second row, and an angle after it."""
    lines = [f"{t:g},{0 if i < 1 else 20},{i}" for i, t in enumerate(times_s)]
    rows = "\n".join(["time_s,pressure_kPa,angle_deg", *lines]) + "\n"
    return read([written(folder, rows, 'experiment = "bending"\n')], config)


def test_standing_time_is_refused_where_a_body_moves(tmp_path: Path) -> None:
    times = [0.0, 0.0, 0.1, 0.2, 0.2, 0.3]
    with pytest.raises(ConfigError, match=r"line 6: time_s = 0\.2 again, and pressure_kPa = 20"):
        record(tmp_path, times)
    record(tmp_path, times, Config())
    assert not record(tmp_path, [0.0, 0.0, 0.1, 0.2, 0.3]).warnings  # the control jumps at once


def test_a_gap_is_told_with_its_times(tmp_path: Path) -> None:
    (told,) = record(tmp_path, [0.0, 0.1, 0.2, 0.3, 0.4, 2.0, 2.1]).warnings
    assert "no row from 0.4 to 2 s, elsewhere one every 0.1 s" in told
    assert not record(tmp_path, [0.0, 0.1, 0.2, 0.3, 0.4, 1.2, 1.3]).warnings


def test_rows_too_far_apart_for_a_swing(tmp_path: Path) -> None:
    """At 8 Hz half a swing takes 62.5 ms."""
    assert not aliased(0.0624, 8.0)
    assert "up to 5 Hz" in aliased(0.1, 8.0)
    asked: list[Request] = []

    class Computer:
        """Answers that the slowest swing has 8 Hz."""

        def results(self, requests: Sequence[Request]) -> list[Any]:
            asked.extend(requests)
            return [SimpleNamespace(columns={"frequency_1_Hz": [8.0]})]

    computer: Any = Computer()
    slow = record(tmp_path, [0.0, 0.1, 0.2, 0.3])
    (told,) = undersampled(slow, MOVING, computer)
    assert "0.1 s apart and show swings of up to 5 Hz, but the model's slowest one has 8 Hz" in told
    assert [each.experiment.name for each in asked] == ["vibration"]
    assert not undersampled(slow, Config(), computer)
    assert len(asked) == 1
