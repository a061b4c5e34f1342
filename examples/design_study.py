"""A design study by derivatives: more blocked force at the same centre of gravity.

The paper's finger has two regions, the strain-limiting layer and the bellows, whose thickness
changes by the relative amounts ξ1 and ξ2. A gripper wants a large blocked force F and a small
offset c of the finger's centre of gravity. Both depend on ξ = (ξ1, ξ2). Along the direction

    d ∝ ∇F − (∇F · ∇c)/(∇c · ∇c) ∇c

c does not change to first order, and F rises. Both gradients come without a further simulation:
that of F from the tangent of the solved state, that of c from the geometry alone. One step of 0.1
along d is simulated again.

    scripts/run python examples/design_study.py
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dolfingrip import config
from dolfingrip.config import NO_CHANGE, Change
from dolfingrip.experiments import run
from dolfingrip.experiments.derivatives.gradients import COG, XI, shape_number

SHORT = {
    "finger.bellows": 2,
    "finger.length_mm": 38,
    "mesh.size_mm": 6,
    "mesh.edge_size_mm": 6,
    "experiment.max_pressure_kPa": 50,
    "contact.self_contact": False,
}
"""Two bellows on a coarse mesh: seconds."""

STEP = 0.1


class Design(NamedTuple):
    """A finger and what it does.

    Attributes:
        xi: ξ1 and ξ2.
        force_N: blocked force at the highest pressure.
        offset_mm: of the centre of gravity.
        force_slope: derivatives of the force by ξ (N).
        offset_slope: derivatives of the offset by ξ (mm).
    """

    xi: np.ndarray
    force_N: float
    offset_mm: float
    force_slope: np.ndarray
    offset_slope: np.ndarray


def evaluate(xi: np.ndarray, overrides: Change = NO_CHANGE) -> Design:
    """Simulate one design, with its gradients."""
    places = dict(zip(XI, xi.tolist(), strict=True))
    finger = config.load(overrides={**SHORT, **places, **overrides})
    result = run("blocked_force", finger, gradients=XI)
    last = len(result.rows) - 1
    slopes = {
        each["parameter"]: each["derivative"]
        for each in result.sensitivities
        if each["row"] == last and each["column"] == "force_N"
    }
    offset, offset_slopes = shape_number(COG, finger)
    return Design(
        xi,
        float(result.column("force_N")[-1]),
        offset,
        np.array([slopes[key] for key in XI]),
        np.array([offset_slopes[key] for key in XI]),
    )


def direction(design: Design) -> np.ndarray:
    """Unit direction in which the force rises most while the offset stays to first order."""
    force, offset = design.force_slope, design.offset_slope
    along = force - force @ offset / (offset @ offset) * offset
    return np.asarray(along / np.linalg.norm(along))


def main(overrides: Change = NO_CHANGE) -> tuple[Design, Design]:
    """The original finger, and one step from it."""
    before = evaluate(np.zeros(2), overrides)
    return before, evaluate(before.xi + STEP * direction(before), overrides)


if __name__ == "__main__":
    before, after = main()
    for name, each in (("original", before), ("one step", after)):
        print(
            f"{name}: ξ = ({each.xi[0]:+.3f}, {each.xi[1]:+.3f}), {each.force_N:.4f} N, "
            f"COG offset {each.offset_mm:.3f} mm"
        )
    print(f"{after.force_N / before.force_N - 1:+.1%} force")
