"""Effects on the line of air: their numbers, and derivatives against further runs."""

from __future__ import annotations

import math

import pytest
from support import differences

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import find
from dolfingrip.sections.tables import assignments

SUPPLY = ("supply.source=tank", "supply.leak_mm=0.3", "supply.tube_cm3=4",
          "supply.valve_dm3_per_s_bar=0.02", "supply.gauge_part=0.2")  # fmt: skip
ON = (
    "extensions.leak={}",
    "extensions.dead_volume={}",
    "extensions.starving_valve={}",
    "extensions.gauge_at_the_source.share=0",
)
FILLED = (
    "mesh.size_mm=10", "mesh.edge_size_mm=10", "contact.self_contact=false",
    "protocol.time_s=[0.0, 0.02, 0.04, 0.1, 0.2]",
    "protocol.pressure_kPa=[0.0, 40.0, 40.0, 40.0, 0.0]", "solver.max_step_s=0.01",
    "supply.error_kPa=10",
)  # fmt: skip
KEYS = {
    "extensions.leak.area_mm2": 0.05, "extensions.dead_volume.offset_cm3": 1.0,
    "extensions.starving_valve.factor": 0.8, "extensions.gauge_at_the_source.share": 0.25,
}  # fmt: skip


def test_they_change_numbers_of_the_supply() -> None:
    """Areas of holes add up."""
    there = config.load(None, assignments([*SUPPLY, *(f"{k}={v}" for k, v in KEYS.items())]))
    line = there.adapted().supply
    assert line is not None
    assert math.pi / 4 * line.leak_mm**2 == pytest.approx(math.pi / 4 * 0.3**2 + 0.05)
    assert line.gauge_part == pytest.approx(0.4)
    assert (line.tube_cm3, line.valve_dm3_per_s_bar) == (5.0, pytest.approx(0.016))


def test_they_are_tried_where_there_is_such_a_supply() -> None:
    none, ideal = config.Config(), config.load(None, assignments(["supply.source=ideal"]))
    tank = config.load(None, assignments([*SUPPLY]))
    leak, dead, valve = (effect(name) for name in ("leak", "dead_volume", "starving_valve"))
    assert [leak.possible(at) for at in (none, ideal, tank)] == [False, True, True]
    at_valve = tank.changed(supply={"gauge_part": 1.0})
    gauge = effect("gauge_at_the_source")
    assert [gauge.possible(at) for at in (ideal, tank, at_valve)] == [False, True, False]
    for told, key in ((dead, "supply.tube_cm3"), (valve, "supply.valve_dm3_per_s_bar")):
        assert told.fitted(none) is None
        assert told.fitted(ideal) is None
        number = told.fitted(tank)
        assert number is not None
        assert number.key == key


@pytest.mark.slow
def test_a_leak_that_grows() -> None:
    """In the tenth cycle all readings are those of a leak of that area; in the first of none."""
    tight = [*differences.SHORT, *FILLED, "supply.source=tank", "supply.valve_dm3_per_s_bar=0.02"]
    growing, leaking = (f"extensions.{n}.area_mm2=0.3" for n in ("growing_leak", "leak"))
    none, first, tenth, leak = (
        run("bending", config.load(None, assignments([*tight, *more]))).column(
            "cavity_pressure_kPa"
        )
        for more in ([], [growing], [growing, "protocol.cycle=[10, 10, 10, 10, 10]"], [leaking])
    )
    assert first == pytest.approx(none, abs=1e-6)
    assert tenth == pytest.approx(leak, abs=1e-6)
    assert (none - leak)[3] > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS)
def test_derivatives(key: str) -> None:
    """Of a finger that a tank fills and a valve vents, in the same steps in time."""
    at = config.load(
        None, assignments([*differences.SHORT, *FILLED, *SUPPLY, *ON, f"{key}={KEYS[key]}"])
    )
    (parameter,) = find(at, [key])
    base, slopes = differences.derivatives("bending", at, [parameter])
    found = differences.by_parameter(slopes, key, parameter.scale)
    expected = differences.difference("bending", at, {parameter: parameter.scale})
    read = [{name: row[name] for name in found[0]} for row in expected]
    assert differences.error(base, found, read) < (1e-4, "")
