"""Markers along a finger's back, as a camera sees them: in a diagnosis as any other reading."""

from __future__ import annotations

from pathlib import Path

import pytest
from support import hidden_bending
from support.delivered import delivered
from support.here import Here
from support.measured_files import written

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement

PRESSURES_kPa = (0, 25, 50, 75, 100)
GAIN = 1.04
SEED = 3
NOISE = {"angle_deg": 0.05, "marker_1_x_mm": 0.01, "marker_3_x_mm": 0.02, "curvature_2_per_m": 0.2}
TRIED = ("angle_gain", "mooney_rivlin")


def test_markers_tell_that_the_angle_is_shown_too_large(tmp_path: Path, store: Path) -> None:
    """A softer finger would show larger angles, too, but its markers would move farther."""
    config = hidden_bending.config()
    hidden = {"angle_gain": {"gain": GAIN}}
    file = hidden_bending.measured(tmp_path, hidden, PRESSURES_kPa, SEED, NOISE, markers=3)
    measurement = read([file], config)
    assert set(measurement.listed["column"]) == set(NOISE)
    settings = DiagnosisSettings(quick=True, effects=TRIED)
    found = delivered(diagnose_measurement(measurement, config, Here(store), settings), tmp_path)
    print(found.verdict)
    assert found.verdict.effects == ("angle_gain",)
    assert found.verdict.takes_part > 0.95
    gain = found.numbers["extensions.angle_gain.gain"]
    print(gain)
    assert gain.low < GAIN < gain.high
    assert gain.low > 1.0
    page = (found.folder / "summary.md").read_text(encoding="utf-8")
    assert "marker_3_x_mm" in page


ROWS = "branch,pressure_kPa,{name}\nloading,0,0\nloading,50,-1\n"


@pytest.mark.parametrize(
    ("name", "markers", "said"),
    [
        ("marker_3_x_mm", 0, "allowed: with camera.markers in the set-up, the number of markers"),
        ("marker_3_x_mm", 2, "allowed: those of 2 markers, which camera.markers = 2"),
        ("curvature_3_per_m", 3, "allowed: those of 3 markers"),
        ("marker_0_x_mm", 3, "column marker_0_x_mm: unknown"),
        ("marker_1_y_mm", 3, "column marker_1_y_mm: unknown"),
    ],
)
def test_markers_that_the_finger_has_not(
    tmp_path: Path, name: str, markers: int, said: str
) -> None:
    told = f'experiment = "bending"\n[camera]\nmarkers = {markers}\n'
    file = written(tmp_path, ROWS.format(name=name), told)
    with pytest.raises(ConfigError) as caught:
        read([file], Config())
    assert str(caught.value).startswith(f"{file}: column {name}: ")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_coupon_has_no_markers(tmp_path: Path) -> None:
    told = 'experiment = "coupon"\ngauge_length_mm = 33.0\narea_mm2 = 9.0\n'
    rows = "displacement_mm,force_N,marker_1_x_mm\n0,0,0\n1,1,1\n"
    with pytest.raises(ConfigError, match="marker_1_x_mm = 0: coupon does not read it"):
        read([written(tmp_path, rows, told)], Config())
