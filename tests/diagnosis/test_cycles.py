"""A record of many cycles that is read in a few: fatigue is simulated in those alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import bars
from support.here import Here
from support.measured_files import written

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.simulation.simulated import groups

TOLD = 'experiment = "bending"\n'


def rows(*cycles: int) -> str:
    """Up and down in each of these cycles, of 10 s each."""
    lines = ["cycle,time_s,pressure_kPa,angle_deg"]
    for cycle in cycles:
        way = [(0, 0), (2, 20), (4, 40), (6, 20), (8, 0)]
        lines += [f"{cycle},{10 * cycle + s},{kPa},{kPa}" for s, kPa in way]
    return "\n".join(lines) + "\n"


def test_of_a_thousand_cycles_four_are_simulated(tmp_path: Path) -> None:
    file = written(tmp_path, rows(1, 10, 100, 1000), TOLD)
    (group,) = groups(read([file]), Config())
    tired = group.config.changed(extensions={"fatigue": {}})
    way = group.schedule(tired).protocol()
    assert dict.fromkeys(way["cycle"]) == dict.fromkeys([1, 10, 100, 1000])
    assert len(way["cycle"]) < 60
    assert group.feels("extensions.fatigue.softening")


def test_few_cycles_tell_nothing_of_fatigue(tmp_path: Path) -> None:
    file = written(tmp_path, rows(1, 2, 3), TOLD)
    (group,) = groups(read([file]), Config())
    assert not group.feels("extensions.fatigue.softening")
    assert group.feels("extensions.mullins.inverse_r")


@pytest.mark.slow
def test_a_tired_coupon(tmp_path: Path, store: Path) -> None:
    """The finite-element bar in four of a thousand cycles, which closed forms diagnose."""
    seed, softening = 6, 0.06
    print("seed", seed)
    travel = np.tile([0.0, 3.0, 6.0, 9.0, 6.0, 3.0], 4)
    cycle = np.repeat([1, 10, 100, 1000], 6)
    time_s = 20.0 * cycle + np.tile(np.arange(6.0), 4) - 20
    hidden = bars.pull(
        f"extensions.fatigue.softening={softening}", "extensions.fatigue.g=0.05",
        *bars.protocol(time_s, travel), f"protocol.cycle={cycle.tolist()}",
    )  # fmt: skip
    force_N = hidden.column("force_N") + 0.01 * np.random.default_rng(seed).standard_normal(24)
    lines = ["cycle,time_s,displacement_mm,force_N"]
    rows = zip(cycle, time_s, travel, force_N, strict=True)
    lines += [f"{n},{t:g},{mm:g},{force:.5f}" for n, t, mm, force in rows]
    coupon = Config().coupon
    told = f"""experiment = "coupon"
gauge_length_mm = {coupon.gauge_length_mm}
area_mm2 = {coupon.area_mm2}
[noise]
force_N = 0.01
"""
    file = written(tmp_path, "\n".join(lines) + "\n", told)
    settings = DiagnosisSettings(effects=("fatigue", "mullins", "temperature_drift"))
    found = diagnose_measurement(read([file]), Config(), Here(store), settings)
    assert (found.decision.answer, found.decision.first) == ("cause", ("fatigue",))
    (tired,) = (n for n in found.numbers(found.decision.best) if n.key.endswith("softening"))
    print(tired)
    assert tired.low < softening < tired.high
