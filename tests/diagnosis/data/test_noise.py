"""Noise: as told, else estimated."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.measured_files import TOML, written

from dolfingrip.diagnosis.answer.noise import drifting, instrument_noise
from dolfingrip.diagnosis.data.measurement import Measurement, read

SEED = 5
UNTOLD = 'experiment = "bending"\n'


def measured(folder: Path, rows: int, cycles: int, toml: str) -> Measurement:
    """A parabola that is read with noise of 0.4°, up and down."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    up = np.linspace(0, 100, rows)
    lines = ["cycle,branch,time_s,pressure_kPa,angle_deg"]
    time_s = 0
    for cycle in range(1, cycles + 1):
        for branch, values in (("loading", up), ("unloading", up[::-1])):
            for value in values:
                angle = 0.2 * value + 0.002 * value**2 + rng.normal(0, 0.4)
                lines.append(f"{cycle},{branch},{time_s},{value:.3f},{angle:.4f}")
                time_s += 1
    return read([written(folder, "\n".join(lines) + "\n", toml)])


def test_told(tmp_path: Path) -> None:
    found, sources = instrument_noise(read([written(tmp_path)]))
    np.testing.assert_array_equal(found.independent, [*4 * [0.3], 0.02, 0.3, 0.02])
    np.testing.assert_array_equal(found.control, np.full(7, 0.5))
    assert not found.correlated.any()
    assert np.isinf(found.correlation_time_s).all()
    assert sources == ()
    assert "correlated" not in TOML


@pytest.mark.parametrize(
    ("rows", "cycles", "how"),
    [(80, 1, "scatter"), (8, 6, "repeats")],
)
def test_estimated(tmp_path: Path, rows: int, cycles: int, how: str) -> None:
    """Of 150 and 64 differences: three standard errors of a standard deviation are 30 %."""
    found, sources = instrument_noise(measured(tmp_path, rows, cycles, UNTOLD))
    assert found.independent.to_numpy() == pytest.approx(0.4, rel=0.3)
    (said,) = sources
    assert (said.column, said.source) == ("angle_deg", how)
    assert found.independent.to_numpy() == pytest.approx(said.std)


def test_guessed_where_readings_are_few(tmp_path: Path) -> None:
    found, sources = instrument_noise(measured(tmp_path, 6, 1, UNTOLD))
    assert set(found.independent) == {0.3}
    assert sources[0].source == "guess"


def test_readings_that_repeat_exactly_tell_no_noise(tmp_path: Path) -> None:
    """Cycles of readings in whole degrees may not differ at all; that is no noise of 0."""
    lines = ["cycle,branch,time_s,pressure_kPa,angle_deg"]
    for cycle in range(1, 5):
        for i, (branch, value) in enumerate((*_UP, *_DOWN)):
            lines.append(f"{cycle},{branch},{10 * cycle + i},{value},{value // 3}")
    found, _ = instrument_noise(read([written(tmp_path, "\n".join(lines) + "\n", UNTOLD)]))
    assert set(found.independent) == {0.3}


_UP = [("loading", value) for value in (10, 20, 30, 40)]
_DOWN = [("unloading", value) for value in (30, 20, 10)]


def test_noise_that_fades_as_the_markers_move(tmp_path: Path) -> None:
    """Markers that are 3 mm on, and 4 mm across, are 5 mm apart: e⁻¹ with a length of 5 mm."""
    rows = ["pressure_kPa,marker_1_x_mm,marker_1_z_mm", "0,1,10", "50,1,10", "100,4,14"]
    told = """
[camera]
markers = [[1, 10]]
[noise]
marker_1_x_mm = 0.1
marker_1_z_mm = 0.1
[noise.correlated]
marker_1_x_mm = 0.2
correlation_length_mm = 5
"""
    measurement = read([written(tmp_path, "\n".join(rows) + "\n", UNTOLD + told)])
    covariance = drifting(measurement, instrument_noise(measurement)[0])
    along_x = (measurement.listed["column"] == "marker_1_x_mm").to_numpy()
    far = np.exp(-1)
    expected = 0.04 * np.array([[1, 1, far], [1, 1, far], [far, far, 1]])
    np.testing.assert_allclose(covariance[np.ix_(along_x, along_x)], expected)
    assert not covariance[~along_x].any()
