"""Blocked force, and how it depends on the finger's walls.

The tip presses on the plate of a force sensor. The plate is a rigid plane that the skin cannot
pass, with the barrier potential Π_plate. The sensor's reading is the derivative of the whole
potential by the plate's place, F = dΠ/d(place).

A derivative by a parameter m needs no second simulation. At equilibrium R(u; m) = 0, so

    K du/dm = −∂R/∂m,

with the tangent K that Newton's method has anyway. The example holds the derivative by the
thickness of the walls against a finger whose walls are thicker by 1 %.

    scripts/run python examples/blocked_force.py
"""

from __future__ import annotations

from typing import NamedTuple

from dolfingrip import config
from dolfingrip.config import NO_CHANGE, Change
from dolfingrip.experiments import Result, run

SHORT = {
    "finger.bellows": 2,
    "finger.length_mm": 38,
    "mesh.size_mm": 6,
    "mesh.edge_size_mm": 6,
    "experiment.max_pressure_kPa": 50,
    "contact.self_contact": False,
}
"""Two bellows on a coarse mesh: seconds."""

WALL = "finger.wall_mm"
WALL_mm = 1.6
SHARE = 0.01


class Found(NamedTuple):
    """Results of the example.

    Attributes:
        force_N: at the highest pressure.
        slope_N_per_mm: derivative of that force by the walls' thickness.
        predicted_N, computed_N: force with thicker walls, by the derivative and by simulation.
    """

    force_N: float
    slope_N_per_mm: float
    predicted_N: float
    computed_N: float


def last_slope(result: Result, column: str) -> float:
    """Derivative of a column at the last reading by the only parameter that was asked for."""
    slopes = [each["derivative"] for each in result.sensitivities if each["column"] == column]
    return float(slopes[-1])


def main(overrides: Change = NO_CHANGE) -> Found:
    """Simulate twice and compare."""
    settings = {**SHORT, **overrides}
    result = run("blocked_force", config.load(overrides=settings), gradients=[WALL])
    force, slope = float(result.column("force_N")[-1]), last_slope(result, "force_N")
    more = SHARE * WALL_mm
    thicker = run("blocked_force", config.load(overrides={**settings, WALL: WALL_mm + more}))
    return Found(force, slope, force + slope * more, float(thicker.column("force_N")[-1]))


if __name__ == "__main__":
    found = main()
    print(f"blocked force {found.force_N:.4f} N at 50 kPa")
    print(f"1 mm thicker walls: {found.slope_N_per_mm:+.4f} N")
    print(
        f"1 % thicker walls: {found.predicted_N:.5f} N predicted, {found.computed_N:.5f} N computed"
    )
