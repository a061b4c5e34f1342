"""A gripper that closes on a block, on any number of ranks; the reference is one."""

from __future__ import annotations

import numpy as np
import pytest
from experiments import small
from mpi4py import MPI

from dolfingrip.experiments import run

CLOSING = (
    *("food.width_mm=14", "food.length_mm=30", "food.height_mm=24", "food.density_kg_m3=300"),
    *("gripper.pose=pinch", "gripper.clearance_mm=1", "gripper.step_s=0.5", "gripper.lift_mm=1"),
    *("experiment.max_pressure_kPa=30", "experiment.step_kPa=30", "solver.rtol=1e-9"),
    *("mesh.size_mm=8.4", "mesh.edge_size_mm=8.4"),
)


def _closed(comm: MPI.Comm, half: str) -> dict[str, float]:
    """The last row of a grasp."""
    result = run("grasp", small.short(*CLOSING, f"gripper.half={half}"), comm=comm)
    assert result.failure is None
    assert result.outcome is not None
    return result.rows[-1]


@pytest.mark.parametrize("half", ["true", "false"])
def test_a_gripper_closes_on_a_block(half: str) -> None:
    alone, together = (_closed(comm, half) for comm in (MPI.COMM_SELF, MPI.COMM_WORLD))
    print(alone)
    assert alone["normal_A_N"] > 0.01
    for name in ("angle", "normal", "object", "table", "slip", "contact_pressure", "friction"):
        for column in (column for column in alone if column.startswith(name)):
            np.testing.assert_allclose(
                together[column], alone[column], rtol=1e-6, atol=1e-7, err_msg=column
            )
