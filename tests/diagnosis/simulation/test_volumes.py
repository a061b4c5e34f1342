"""Measured data of a pump: what it has put into the cavity is prescribed, and not a pressure."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from support.here import Here
from support.measured_files import written

from dolfingrip.config import ConfigError, load
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, simulate
from dolfingrip.experiments import run

SMALL = {"finger.length_mm": 40, "finger.bellows": 2, "mesh.size_mm": 8, "mesh.edge_size_mm": 8}
TIME_S, VOLUME_ML = [0.0, 1.0, 2.0, 4.0, 5.0], [0.0, 0.2, 0.4, 0.4, 0.2]


def measured(folder: Path, head: str, rows: str) -> Measurement:
    return read([written(folder, f"{head}\n{rows}\n", 'experiment = "bending"\n')])


@pytest.mark.slow
def test_readings_are_those_of_a_run_by_volume(tmp_path: Path, store: Path) -> None:
    """The cavity has grown by what was put in, and a diagnosis reads the same curve.

    The reference is the command's own run with the protocol.
    """
    protocol = {"protocol.time_s": TIME_S, "protocol.volume_ml": VOLUME_ML}
    truth = run("bending", load(overrides=SMALL | protocol | {"experiment.control": "volume"}))
    grown_mm3 = truth["cavity_volume_mm3"] - truth["cavity_volume_mm3"][0]
    np.testing.assert_allclose(grown_mm3, 1e3 * np.array(VOLUME_ML), atol=1e-6)
    assert truth["pressure_kPa"][1] < truth["pressure_kPa"][2]
    rows = "\n".join(f"{t},{v},1" for t, v in zip(TIME_S, VOLUME_ML, strict=True))
    measurement = measured(tmp_path, "time_s,volume_ml,angle_deg", rows)
    (test,) = measurement.tests
    assert test.controls == ("volume_ml",)
    assert measurement.readings["branch"].to_list() == [*3 * ("loading",), "hold", "unloading"]
    (found,) = simulate(measurement, load(overrides=SMALL), [ModelVariant()], Here(store))
    np.testing.assert_allclose(found.readings, truth["angle_deg"], atol=1e-6)


@pytest.mark.parametrize(
    ("head", "rows", "said"),
    [
        ("time_s,volume_ml,pressure_kPa,angle_deg", "0,0,0,0\n1,1,5,5", "both told; allowed: what"),
        ("time_s,volume_ml,pressure_kPa,angle_deg", "0,0,,0\n1,,5,5", "line 3: volume_ml: missing"),
    ],
)
def test_a_bad_volume(head: str, rows: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=re.escape(said)):
        measured(tmp_path, head, rows)


def test_volumes_without_times_have_those_of_an_ordinary_ramp(tmp_path: Path) -> None:
    """Photographs have no time: the pump takes as long as a ramp to the highest pressure."""
    found = measured(tmp_path, "volume_ml,angle_deg", "0,0\n1,5\n2,9\n0,0")
    experiment = load().experiment
    ramp_s = experiment.max_pressure_kPa / experiment.rate_kPa_per_s
    expected = np.array([0, 0.5, 1, 2]) * ramp_s
    np.testing.assert_allclose(found.readings["time_s"], expected)
    assert f"{2 / ramp_s:g} ml/s is assumed" in found.warnings[0]


def test_a_protocol_of_volumes_needs_volume_control() -> None:
    """It is refused in one line before anything is computed."""
    config = load(overrides={"protocol.time_s": [0, 1], "protocol.volume_ml": [0, 1]})
    with pytest.raises(ConfigError, match='control = "pressure": allowed: "volume" with this'):
        run("bending", config)
