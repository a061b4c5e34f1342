"""Commands of a supply against closed forms of a rigid chamber, and against finite elements."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command import run_command
from support.small import SHORT

from dolfingrip import config
from dolfingrip.config import KPA, Config, ConfigError
from dolfingrip.experiments import command_for
from dolfingrip.experiments import run as experiment
from dolfingrip.experiments.feedforward import Filling
from dolfingrip.experiments.filling import RestingFinger, step_response
from dolfingrip.experiments.results.following import REACHED
from dolfingrip.mechanics.model.pneumatics import REFERENCE_MPA, Line, Restriction
from dolfingrip.sections.tables import assignments

VOLUME = 1e5
"""Volume of the rigid chamber (mm³)."""
CHAMBER = RestingFinger(np.array([0.0, 200.0]), np.full(2, VOLUME), np.zeros(2))
VALVE = Restriction(1e5, 0.3)
WIDE = Restriction(1e8, 0.3)
"""A tube that hardly resists."""
TANK_MPA = 1.0


def rigid(line: Line, highest_kPa: float = 0.0) -> Filling:
    """A chamber that does not give way."""
    return Filling(line, lambda kPa: VOLUME, highest_kPa * KPA)


def choked_tank() -> Line:
    """A line from a tank that is so large that its pressure stays."""
    return Line(VALVE, VALVE, WIDE, 1.0, tank_mm3=1e12, tank_MPa=TANK_MPA)


def test_valve_is_open_as_far_as_a_choked_ramp_needs() -> None:
    """V dp/dt = p₀ q with q = part · C · p_tank, as the flow is choked up to 0.3 of the tank's."""
    rate = 0.05  # MPa/s
    steps = 0.02 * np.arange(1, 51)
    ends = list(rigid(choked_tank()).following(rate * steps, 0.02))
    part = VOLUME * rate / (REFERENCE_MPA * VALVE.conductance * TANK_MPA)
    assert part < 1
    for pressure, (cavity, tube, command) in zip(rate * steps, ends, strict=True):
        assert cavity - 0.101325 == pytest.approx(pressure, rel=1e-6)
        assert tube == pytest.approx(cavity, rel=1e-3)
        assert command == pytest.approx(part, rel=2e-3)


def test_fastest_filling_is_that_of_a_choked_valve() -> None:
    open_line = replace(choked_tank(), commanded=(1.0, 0.0))
    found = step_response(CHAMBER, open_line, 0.0, 150.0)
    choked = VOLUME * REACHED * 0.15 / (REFERENCE_MPA * VALVE.conductance * TANK_MPA)
    assert found.reached_s == pytest.approx(choked, rel=2e-3)


def test_a_curve_that_is_too_fast_is_followed_fully_open() -> None:
    """The pressure then lacks what the choked valve cannot bring; it is vented fully open, too."""
    wished = np.r_[np.full(5, 0.15), np.zeros(5)]
    ends = np.array(list(rigid(choked_tank()).following(wished, 0.02)))
    rise = REFERENCE_MPA * VALVE.conductance * TANK_MPA * 0.02 / VOLUME
    assert np.diff(ends[:5, 0]) == pytest.approx(rise, rel=2e-3)
    assert list(ends[:5, 2]) == [1.0] * 5
    assert list(ends[5:, 2]) == [-1.0] * 5
    assert (np.diff(ends[4:, 0]) < 0).all()


def test_a_weak_regulator_never_fills() -> None:
    """A set point of 100 kPa does not bring 120 kPa; the chamber stays below its own."""
    line = Line(VALVE, VALVE, WIDE, 1.0)
    found = step_response(CHAMBER, line, 100.0, 120.0)
    assert found.reached_s == float("inf")
    assert found.cavity_kPa[-1] == pytest.approx(100.0, rel=0.01)


def short(*overrides: str) -> Config:
    changes = ["supply.valve_dm3_per_s_bar=0.01", "experiment.max_pressure_kPa=40"]
    return config.load(None, assignments([*SHORT, *changes, *overrides]))


@pytest.mark.slow
def test_finite_elements_follow_the_commands() -> None:
    """The finger with its supply has the pressures that its cavity's volume at rest told.

    The commands hold for a step of 20 ms; the simulation ramps them, and so is late by half a step
    of what the rate changes by, at most 75 + 50 kPa/s.
    """
    settings = short()
    found = command_for(
        settings, [0.0, 0.4, 0.8], pressure_kPa=[0.0, 30.0, 10.0], every_s=0.02, regulator_kPa=40.0
    )
    assert np.abs(found.reached_kPa - found.wished_kPa).max() < 1e-3
    assert np.abs(found.commands["set_point_kPa"] - found.wished_kPa).max() > 1.0  # it leads
    protocol = {
        "time_s": [0.0, *found.time_s],
        "pressure_kPa": [0.0, *found.commands["set_point_kPa"]],
    }
    result = experiment("bending", settings.changed(protocol=protocol))
    assert result.failure is None
    cavity = result.column("cavity_pressure_kPa")[1:]
    assert np.abs(cavity - found.reached_kPa).max() < 125.0 * 0.01
    assert np.median(np.abs(cavity - found.reached_kPa)) < 0.5


@pytest.mark.parametrize(
    ("curve", "overrides", "said"),
    [
        ({"pressure_kPa": [0.0, 30.0]}, ["supply.source=syringe", "experiment.control=volume"],
         'supply.source = "syringe": allowed: "ideal", "pump", "tank"'),
        ({"pressure_kPa": [0.0, -30.0]}, [], "pressure_kPa = -30: allowed: 0 to inf kPa"),
        ({"pressure_kPa": [0.0, 0.0]}, [], "pressure_kPa = 0 all along: allowed: a curve that"),
        ({}, [], "a curve: allowed: one of pressure_kPa and angle_deg"),
    ],
)  # fmt: skip
def test_refusals(curve: dict[str, list[float]], overrides: list[str], said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        command_for(short(*overrides), [0.0, 1.0], **curve)  # type: ignore[arg-type]
    assert str(refused.value).startswith(said)


def test_command_writes_table_and_picture(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    """An angle is wished; the finger bends as far where its supply is fast enough."""
    curve, out = tmp_path / "wished.csv", tmp_path / "out"
    curve.write_text("time_s,angle_deg\n0,0\n1,2\n", encoding="utf-8")
    set_keys = [word for each in (*SHORT, "experiment.max_pressure_kPa=40",
                                  "supply.valve_dm3_per_s_bar=0.05")
                for word in ("--set", each)]  # fmt: skip
    assert run_command("supply", str(curve), "--every", "0.1", *set_keys, "--out", str(out)) == 0
    rows = np.genfromtxt(out / "commands.csv", delimiter=",", names=True)
    assert rows["angle_deg"] == pytest.approx(0.2 * np.arange(1, 11), abs=0.02)
    assert (np.diff(rows["set_point_kPa"]) > 0).all()
    assert (out / "commands.png").stat().st_size > 10_000
    assert "it follows the curve within" in capsys.readouterr().out
    assert run_command("supply", str(curve), "--every", "2", *set_keys, "--out", str(out)) == 2
