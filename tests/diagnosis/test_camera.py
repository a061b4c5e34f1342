"""A camera's errors in a diagnosis: named where they are far off, and no other cause beside them.

Tables are made of simulated markers by a pinhole camera in space (``support/pinhole.py``).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import hidden_bending, small
from support.delivered import Delivered, delivered
from support.here import Here
from support.measured_files import written
from support.pinhole import Pinhole

from dolfingrip.channels import marker
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.experiments import run

PRESSURES_kPa = (0, 50, 100, 150, 200)
DISTANCE_mm = 150.0
MARKERS = np.array([[2.0, z] for z in (4.0, 11.0, 18.0, 25.0, 32.0, 36.5)])
RULER = np.array([[-40.0, 15.0], [10.0, 15.0]])
SEED = 73
TOLD = """experiment = "bending"
[noise]
{noise}
[camera]
markers = {markers}
distance_mm = 150.0
centre_mm = [-10.0, 15.0]
scale_mm = [[-40.0, 15.0], [10.0, 15.0]]
[nuisance]
camera_scale = 0.004
camera_tilt_deg = 2.0
camera_zero_mm = 0.1
camera_clock_s = 0.05
"""
TRIED = (
    "camera_scale", "camera_tilt", "camera_zero", "camera_clock", "mooney_rivlin",
    "base_layer_offset", "wall_offset",
)  # fmt: skip


def filmed(folder: Path, hidden: Mapping[str, Any], tilt_deg: float, noise_mm: float) -> Path:
    """The table of a video by a camera that was tilted; a scale of two points is told."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    names = [marker(i, axis).name for i in range(1, len(MARKERS) + 1) for axis in "xz"]
    protocol = {"time_s": [10 * i for i in range(len(PRESSURES_kPa))],
                "pressure_kPa": PRESSURES_kPa}  # fmt: skip
    truth = hidden_bending.config(*small.FEW).changed(
        camera={"markers": MARKERS.tolist()}, protocol=protocol, extensions=hidden
    )
    places = np.array([run("bending", truth).column(name) for name in names])
    places = places.T.reshape(len(PRESSURES_kPa), len(MARKERS), 2)
    pinhole = Pinhole(tilt_deg, 0.0, DISTANCE_mm, (-10.0, 15.0))
    shown = pinhole.read(places, MARKERS[[0, -1]], RULER)
    shown += noise_mm * rng.standard_normal(shown.shape)
    at_rest = pinhole.read(MARKERS, MARKERS[[0, -1]], RULER)
    lines = [",".join(["branch", "time_s", "pressure_kPa", *names])]
    for i, (pressure, row) in enumerate(zip(PRESSURES_kPa, shown, strict=True)):
        values = ",".join(f"{value:.6f}" for value in row.ravel())
        lines.append(f"loading,{10 * i},{pressure},{values}")
    noise = "\n".join(f"{name} = {noise_mm}" for name in names)
    told = TOLD.format(noise=noise, markers=at_rest.round(4).tolist())
    return written(folder, "\n".join(lines) + "\n", told)


def diagnosed(
    folder: Path, store: Path, hidden: Mapping[str, Any], tilt_deg: float, noise_mm: float,
    *, quick: bool = True,
) -> Delivered:  # fmt: skip
    config = hidden_bending.config(*small.FEW)
    measurement = read([filmed(folder, hidden, tilt_deg, noise_mm)], config)
    settings = DiagnosisSettings(quick=quick, effects=TRIED)
    found = delivered(diagnose_measurement(measurement, config, Here(store), settings), folder)
    print(found.verdict)
    return found


@pytest.mark.slow
def test_a_hidden_tilt_is_the_camera_s(tmp_path: Path, store: Path) -> None:
    """A tilt of 8° in a video with markers and a scale of two points."""
    found = diagnosed(tmp_path, store, {}, 8.0, 0.02)
    assert found.verdict.effects == ("camera_tilt",)
    assert found.verdict.takes_part > 0.9
    tilt = found.numbers["extensions.camera_tilt.about_z_deg"]
    print(tilt)
    assert tilt.low < 8.0 < tilt.high
    assert tilt.low > 4.0
    assert "a camera that was tilted" in (found.folder / "summary.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_another_cause_beside_an_ordinary_camera(tmp_path: Path, store: Path) -> None:
    """A tilt of 1.5° is within what was told, and named is what the finger has."""
    hidden = {"base_layer_offset": {"offset_mm": 0.4}}
    found = diagnosed(tmp_path, store, hidden, 1.5, 0.003)
    assert found.verdict.effects == ("base_layer_offset",)
    assert not found.verdict.second


@pytest.mark.slow
def test_a_law_beside_an_ordinary_camera(tmp_path: Path, store: Path) -> None:
    """The same of Mooney and Rivlin's law, which is simulated at strengths of its own."""
    hidden = {"mooney_rivlin": {"C01_MPa": 1.2}}
    found = diagnosed(tmp_path, store, hidden, 1.5, 0.004, quick=False)
    assert found.verdict.effects == ("mooney_rivlin",)
    assert not found.verdict.second
    number = found.numbers["extensions.mooney_rivlin.C01_MPa"]
    assert number.low < 1.2 < number.high


def test_a_camera_is_in_the_place_of_a_sensor(tmp_path: Path) -> None:
    """Its errors are causes where they are told, and those of a sensor of the angle are not."""
    rows = "pressure_kPa,angle_deg\n0,0\n25,2\n50,4\n"
    told = 'experiment = "bending"\n[nuisance]\ncamera_tilt_deg = 1.0\ncamera_zero_deg = 0.2\n'
    config, names = Config(), {}
    for toml in ('experiment = "bending"\n', told):
        measurement = read([written(tmp_path, rows, toml)], config)
        names[toml] = {cause.name: cause for cause in unknowns(measurement, config)}
    sensor, camera = names.values()
    assert {"angle_gain", "angle_offset", "angle_lag"} <= sensor.keys()
    assert not any(name.startswith("camera") for name in sensor)
    assert {name for name in camera if name.startswith("camera")} == {"camera_tilt", "camera_zero"}
    assert not {"angle_gain", "angle_offset"} & camera.keys()
    assert "angle_lag" in camera
    (zero,) = camera["camera_zero"].numbers
    assert zero.prior.spread == pytest.approx(4 * 0.2)
    with pytest.raises(ConfigError, match="--effects angle_gain: allowed: camera_tilt"):
        unknowns(measurement, config, ["angle_gain"])
    with pytest.raises(ConfigError, match=r"camera_scale: allowed: with \[nuisance\] camera_scale"):
        unknowns(measurement, config, ["camera_scale"])
