"""A gripper that closes on a block: any number of ranks find what one found."""

from __future__ import annotations

import pytest
from mpi4py import MPI
from support import small, stored

from dolfingrip.experiments import run

pytestmark = pytest.mark.two_ranks

CLOSING = (
    *("food.width_mm=14", "food.length_mm=30", "food.height_mm=24", "food.density_kg_m3=300"),
    *("gripper.pose=pinch", "gripper.clearance_mm=1", "gripper.step_s=0.5", "gripper.lift_mm=1"),
    *("experiment.max_pressure_kPa=30", "experiment.step_kPa=30", "solver.rtol=1e-9"),
    *("mesh.size_mm=8.4", "mesh.edge_size_mm=8.4"),
)


PREFIXES = ("angle", "normal", "object", "table", "slip", "contact_pressure", "friction")


def _closed(half: str) -> dict[str, float]:
    """The last row of a grasp."""
    result = run("grasp", small.short(*CLOSING, f"gripper.half={half}"), comm=MPI.COMM_WORLD)
    assert result.failure is None
    assert result.outcome is not None
    return result.rows[-1]


@pytest.mark.parametrize("half", ["true", "false"])
def test_a_gripper_closes_on_a_block(half: str) -> None:
    row = _closed(half)
    assert row["normal_A_N"] > 0.01
    found = {column: value for column, value in row.items() if column.startswith(PREFIXES)}
    stored.compare(f"a gripper that closes on a block, half={half}", found, rtol=1e-6, atol=1e-7)
