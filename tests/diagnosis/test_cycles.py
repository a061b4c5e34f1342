"""A record of many cycles that is read in a few: fatigue is simulated in those alone."""

from __future__ import annotations

from pathlib import Path

from support.measured_files import written

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import read
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
