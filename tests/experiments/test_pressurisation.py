"""Readings in order, and a finger under volume control."""

from __future__ import annotations

import pytest
from support import small

from dolfingrip.experiments import pressures_kPa, run
from dolfingrip.experiments.protocol import advice, pressure_stops, stops_by_volume


def test_pressures() -> None:
    """Up in steps to a maximum that is no multiple of them, and back."""
    config = small.short(
        "experiment.max_pressure_kPa=50", "experiment.step_kPa=20", "experiment.unload=true"
    )
    assert pressures_kPa(config) == [0, 20, 40, 50, 40, 20, 0]
    assert [stop.branch for stop in pressure_stops(config)] == 4 * ["loading"] + 3 * ["unloading"]


@pytest.mark.parametrize(
    ("settings", "ratio", "changes"),
    [
        ([], 1.5, ["control=auto"]),
        ([], 3.4, ["control=auto", "max_volume_ratio=7"]),
        (["experiment.control=auto"], 1.9, ["max_volume_ratio=4"]),
        (["experiment.unload=true"], 1.5, ["control=volume"]),
        (["experiment.cycles=2"], 1.5, ["control=volume"]),
    ],
)
def test_what_is_advised_at_a_limit_point_is_allowed(
    settings: list[str], ratio: float, changes: list[str]
) -> None:
    """The settings that it names can be added, and then the cavity has room to grow."""
    said = advice(small.short(*settings), ratio)
    assert said.startswith(f"the cavity is {ratio:g} times as large as at rest")
    assignments = [f"experiment.{change}" for change in changes]
    assert said.endswith(f"it can grow on with {' '.join(f'--set {each}' for each in assignments)}")
    assert stops_by_volume(small.short(*settings, *assignments), ratio - 1, 0.0)


def test_nothing_is_advised_with_a_protocol() -> None:
    followed = small.short().changed(protocol={"time_s": [0.0, 1.0], "pressure_kPa": [0.0, 10.0]})
    assert advice(followed, 1.5) == ""


def test_volume_and_pressure_agree() -> None:
    """Under volume control the finger passes the states of pressure control at the same pressures.

    Both paths solve the same equations, so the angle differs by the solver's tolerance only.
    """
    by_volume = small.short(
        'experiment.control="volume"',
        "experiment.max_volume_ratio=1.1",
        "experiment.step_volume_ratio=0.05",
        "solver.rtol=1e-10",
    )
    assert pressures_kPa(by_volume) == []
    inflated = run("bending", by_volume)
    assert inflated.failure is None
    volumes = inflated.column("cavity_volume_mm3")
    assert volumes / volumes[0] == pytest.approx([1, 1.05, 1.1], rel=1e-9)
    assert list(inflated.column("time_s")) == [0, 1, 2]

    pressure = float(inflated.column("pressure_kPa")[-1])
    assert pressure > 10
    by_pressure = small.short(
        f"experiment.max_pressure_kPa={pressure!r}",
        f"experiment.step_kPa={pressure!r}",
        "solver.rtol=1e-10",
    )
    pressed = run("bending", by_pressure)
    for name in ("angle_deg", "tip_x_mm", "cavity_volume_mm3"):
        assert inflated.column(name)[-1] == pytest.approx(pressed.column(name)[-1], rel=1e-7)
