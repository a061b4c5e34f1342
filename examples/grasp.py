"""Three short fingers pinch a block and lift it.

The fingers are quasi-static, the block is a rigid body with weight and inertia. Friction holds it:
with the coefficient μ, normal forces N_i bear a weight W up to

    W = μ Σ N_i.

At the end of a lift nothing touches the table, so the vertical forces of the fingers have to be the
weight, whatever the contact's numbers are. The whole gripper keeps its books: what the pressure has
worked is stored in the walls, lifted as weight, or lost by friction.

    scripts/run python examples/grasp.py
"""

from __future__ import annotations

from typing import NamedTuple

from dolfingrip import config
from dolfingrip.config import NO_CHANGE, Change
from dolfingrip.experiments import Result, run

SIZE_mm = (14.0, 30.0, 24.0)
DENSITY_kg_m3 = 300.0
WEIGHT_N = 9.81e-9 * DENSITY_kg_m3 * SIZE_mm[0] * SIZE_mm[1] * SIZE_mm[2]
GRIPPER = {
    "finger.bellows": 2,
    "finger.length_mm": 38,
    "mesh.size_mm": 8.4,
    "mesh.edge_size_mm": 8.4,
    "gripper.pose": "pinch",
    "gripper.clearance_mm": 4,
    "gripper.lift_mm": 6,
    "gripper.step_s": 0.2,
    "food.kind": "cube",
    "food.width_mm": SIZE_mm[0],
    "food.length_mm": SIZE_mm[1],
    "food.height_mm": SIZE_mm[2],
    "food.density_kg_m3": DENSITY_kg_m3,
    "food.friction": 0.5,
    "experiment.max_pressure_kPa": 100,
    "experiment.step_kPa": 50,
}


class Found(NamedTuple):
    """Results of the example.

    Attributes:
        result: all readings.
        outcome: what became of the block.
        borne_N: vertical force of all fingers at the end.
        normal_N: sum of their normal forces.
    """

    result: Result
    outcome: str
    borne_N: float
    normal_N: float


def main(overrides: Change = NO_CHANGE) -> Found:
    """Grasp and lift. Pose and block are symmetric, so half of the gripper is computed."""
    result = run("grasp", config.load(overrides={**GRIPPER, **overrides}))
    last = result.rows[-1]
    borne, normal = (
        sum(last[f"{name}_{finger}_N"] for finger in "ABC") for name in ("lift", "normal")
    )
    return Found(result, str(result.outcome.kind.value if result.outcome else ""), borne, normal)


if __name__ == "__main__":
    found = main()
    print(f"{found.outcome}: {found.borne_N:.4f} N borne, the block weighs {WEIGHT_N:.4f} N")
    print(f"friction would bear {0.5 * found.normal_N:.3f} N")
