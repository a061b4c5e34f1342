"""A sensor of the angle that lags behind, and a line that does: which of them the readings tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import small
from support.here import Here
from support.measured_files import written

from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.experiments import run

TAU_S = 0.25
SEED = 11
TIMES_s = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 3.0, 3.25, 3.5, 3.75, 4.0)
PRESSURES_kPa = (0, 15, 30, 45, 60, 60, 60, 45, 30, 15, 0)
BRANCHES = ("loading",) * 5 + ("hold",) * 2 + ("unloading",) * 4
NOISE = {"angle_deg": 0.03, "force_N": 0.002}
TOLD = """experiment = ["bending", "blocked_force"]
[noise]
angle_deg = 0.03
force_N = 0.002
[plate]
gap_mm = 0.1
"""


def diagnosed(folder: Path, store: Path, *experiments: str) -> Diagnosis:
    """A finger whose angle is shown late, by its readings in one cycle."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    way = {"time_s": TIMES_s, "pressure_kPa": PRESSURES_kPa, "branch": BRANCHES}
    late = small.short(*small.FEW, "plate.gap_mm=0.1", f"extensions.sensor_lag.tau_s={TAU_S}")
    lines = ["experiment,branch,time_s,pressure_kPa,angle_deg,force_N"]
    for name in experiments:
        column = "angle_deg" if name == "bending" else "force_N"
        values = run(name, late.changed(protocol=way)).column(column)
        values += NOISE[column] * rng.standard_normal(len(values))
        for branch, time_s, pressure, value in zip(
            BRANCHES, TIMES_s, PRESSURES_kPa, values, strict=True
        ):
            entry = f"{value:.6f}," if column == "angle_deg" else f",{value:.6f}"
            lines.append(f"{name},{branch},{time_s},{pressure},{entry}")
    file = written(folder, "\n".join(lines) + "\n", TOLD)
    settings = DiagnosisSettings(effects=("sensor_lag", "set_point_logged", "angle_gain"))
    config = small.short(*small.FEW)
    return diagnose_measurement(read([file], config), config, Here(store), settings)


@pytest.mark.slow
def test_a_force_that_is_on_time_tells_the_sensor(tmp_path: Path, store: Path) -> None:
    """The constant within its interval, as it was hidden."""
    found = diagnosed(tmp_path, store, "bending", "blocked_force")
    decision = found.decision
    assert (decision.answer, decision.first, decision.second) == ("cause", ("sensor_lag",), ())
    assert decision.probability > 0.95
    (tau,) = (each for each in found.numbers(decision.best) if each.key.endswith("tau_s"))
    print(tau)
    assert tau.low < TAU_S < tau.high
    assert tau.high - tau.low < 0.2 * TAU_S


@pytest.mark.slow
def test_angles_alone_do_not(tmp_path: Path, store: Path) -> None:
    """A line that lags moves angles of a finger that hardly stiffens in nearly the same way."""
    found = diagnosed(tmp_path, store, "bending")
    print(found.decision.first, found.decision.inclusion)
    assert found.decision.answer == "cause"
    assert {*found.decision.first} == {"sensor_lag", "set_point_logged"}
