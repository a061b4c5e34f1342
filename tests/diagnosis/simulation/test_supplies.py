"""Measured data in which chambers have supplies of their own: every pressure is followed."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from support import hexagon
from support.here import Here
from support.measured_files import written

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.simulation.simulated import ModelVariant, groups, simulate
from dolfingrip.experiments import run

OWN = "cavity_2_supply_kPa"
ROWS = np.array([
    # s, kPa, kPa
    (0, 0, 0), (1, 10, 0), (2, 20, 0), (3, 20, -5), (4, 20, -10), (6, 20, -10), (10, 20, -10),
    (11, 10, -5), (12, 0, 0),
])  # fmt: skip


def measured(folder: Path, rows: np.ndarray = ROWS, noise: str = "") -> Measurement:
    lines = [f"time_s,pressure_kPa,{OWN},tip_x_mm"]
    lines += [",".join(map(str, (*row, 1.0))) for row in rows.tolist()]
    told = f'experiment = "bending"\n{noise}'
    return read([written(folder, "\n".join(lines) + "\n", told)])


def test_the_stops_follow_every_supply(tmp_path: Path) -> None:
    """Ramps of one chamber after the other, a wait, and both at once: the rows are the stops."""
    measurement = measured(tmp_path)
    (test,) = measurement.tests
    assert test.supplies == ("pressure_kPa", OWN)
    assert measurement.readings["branch"].to_list() == [
        *5 * ("loading",), *2 * ("hold",), *2 * ("unloading",),
    ]  # fmt: skip
    (group,) = groups(measurement, Config())
    assert group.curve is None  # no single pressure tells the state
    way = group.schedule(Config())
    for name, expected in zip(("time_s", "pressure_kPa", OWN), ROWS.T, strict=True):
        np.testing.assert_allclose(way.protocol()[name], expected)
        np.testing.assert_allclose(way.at_rows(expected, len(ROWS)), expected, atol=1e-12)


def test_dense_rows_of_a_noisy_gauge(tmp_path: Path) -> None:
    """Few stops; what rests stays, and what is linear in the pressures is so at every row."""
    seed = 4
    print("seed", seed)
    rng = np.random.default_rng(seed)
    up, rest = np.linspace(0, 40, 150), np.zeros(150)
    pressures = np.column_stack([np.append(up, rest + 40), np.append(rest, -up / 2)])
    told = pressures + rng.normal(0, 0.1, pressures.shape)
    rows = np.column_stack([np.arange(300.0), told])
    (group,) = groups(measured(tmp_path, rows, "[noise]\npressure_kPa = 0.1\n"), Config())
    way = group.settled
    assert len(way.value) < 60
    assert len(way.legs) <= 3  # a short wait where the one ends and the other begins
    main, own = np.array(way.value), np.array(way.others[OWN])
    first, last = (way.legs[i].stops for i in (0, -1))
    assert np.abs(own[first[:-1]]).max() < 0.05
    assert np.ptp(main[last[1:]]) < 0.05
    assert (np.diff(main[first]) > 0).all()
    assert (np.diff(own[last]) < 0).all()
    at_rows = way.at_rows(main + 3 * own, len(rows))
    assert np.abs(at_rows - pressures @ [1.0, 3.0]).max() < 1.0  # of 0.3 kPa of noise


def test_readings_are_those_of_a_run_with_that_protocol(tmp_path: Path, store: Path) -> None:
    """The reference is the command's own run."""
    _, pressure_kPa, own_kPa = ROWS[:5].T
    config = hexagon.driven(tmp_path, pressure_kPa.tolist(), cavity_2=own_kPa.tolist())
    truth = run("bending", config)
    plain = Config().changed(
        **{name: getattr(config, name).model_dump(exclude_defaults=True)
           for name in ("finger", "mesh", "material", "contact")}
    )  # fmt: skip
    (found,) = simulate(measured(tmp_path, ROWS[:5]), plain, [ModelVariant()], Here(store))
    np.testing.assert_allclose(found.readings, truth["tip_x_mm"], atol=1e-9)
    assert np.abs(np.diff(found.readings)[2:]).min() > 1e-4


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("0,0,\n1,5,3", f"line 2: {OWN}: missing; allowed: a number in each row of bending of lab"),
        ("0,0,0\n1,5,-200", f"line 3: {OWN} = -200: allowed: -101.3"),
        ("0,0,0\n1,5,x", f"line 3: {OWN} = x: not a number"),
    ],
)
def test_a_bad_supply(rows: str, said: str, tmp_path: Path) -> None:
    head = f"time_s,pressure_kPa,{OWN},angle_deg\n"
    text = head + "\n".join(f"{row},1" for row in rows.splitlines()) + "\n"
    with pytest.raises(ConfigError, match=re.escape(said)):
        read([written(tmp_path, text, 'experiment = "bending"\n')])
