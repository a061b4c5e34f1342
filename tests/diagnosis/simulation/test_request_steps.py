"""The shortest step of a simulation that a diagnosis asks for."""

from __future__ import annotations

import pytest

from dolfingrip.config import Change, load
from dolfingrip.diagnosis.simulation.runner import request

PROTOCOL: Change = {"protocol.time_s": [0, 0.1, 1.0], "protocol.pressure_kPa": [0, 40, 40]}


@pytest.mark.parametrize(
    ("moving", "least_kPa"),
    [
        ({}, 0.125 * 0.125 * 40),
        ({"experiment.dynamic": True, "material.density_kg_m3": 1000.0}, None),
        ({"supply.source": "tank", "supply.tank_kPa": 200.0}, None),
    ],
)  # fmt: skip
def test_waits_of_what_moves_have_steps_as_short_as_configured(
    moving: Change, least_kPa: float | None
) -> None:
    """An error in time asks for them; a ramp at rest ends where a soft finger balloons."""
    config = load(None, {**PROTOCOL, **moving})
    asked = request("bending", config).config.solver.min_step_kPa
    assert asked == pytest.approx(least_kPa or config.solver.min_step_kPa)
    assert least_kPa is None or asked > config.solver.min_step_kPa
