"""The gripper's model: derivatives of all its terms, where its fingers stand, a whole grasp."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from experiments import small
from mechanics import taylor
from mpi4py import MPI

from dolfingrip.config import ConfigError
from dolfingrip.experiments import run
from dolfingrip.experiments.results.outcome import Kind
from dolfingrip.experiments.results.result import Result
from dolfingrip.experiments.rigs.grasp_readings import GraspReadings
from dolfingrip.experiments.rigs.gripper import GripperModel, build_gripper
from dolfingrip.mechanics.newton.tangent import Tangent

SEED = 41
FOOD = (
    "mesh.half=false",
    "food.width_mm=14",
    "food.length_mm=30",
    "food.height_mm=24",
    "gripper.pose=pinch",
)


@pytest.fixture(scope="module")
def touching() -> GripperModel:
    """Short fingers that just touch a block, all a little displaced, friction held."""
    made = build_gripper(small.short(*FOOD, "gripper.clearance_mm=0.2"), MPI.COMM_SELF)
    model = made.model
    rng = np.random.default_rng(SEED)
    model.prescribe({"time_s": 0.05})
    model.refresh()
    start = model.unknowns.owned()
    moved = 0.01 * _free(made, rng.uniform(-1, 1, start.shape))
    model.unknowns.set_owned(start + moved)
    assert made.contact.gaps_mm(model.u.x.array).min() > 0.02
    assert (made.table.gaps_mm() > 0.02).all()
    return made


def _free(made: GripperModel, direction: np.ndarray) -> np.ndarray:
    """0 where unknowns are held."""
    for bc in made.model.supports:
        direction[bc.dof_indices()[0]] = 0.0
    rows = made.model.unknowns.number_rows(direction)
    rows[len(made.model.unknowns.numbers) :] = 0.0
    return direction


def test_derivatives(touching: GripperModel) -> None:
    """Of weight, inertia, contact and friction of placed fingers and a free body together."""
    print("seed", SEED)
    model = touching.model
    assert (np.bincount(touching.placement.which(_skin(touching)), minlength=3) > 0).all()
    reads = GraspReadings(touching, 1.0)
    assert (reads.normal_N() > 0).all()
    start = model.unknowns.owned()
    direction = _free(touching, np.random.default_rng(SEED + 1).uniform(-1, 1, start.shape))
    tangent = Tangent(model)
    assert model.potential.carried is not None
    model.potential.carried.reset()
    model.heed(0.0)
    tangent.assemble()
    taylor.check_derivatives(model, tangent, direction, 2e-3)


def _skin(made: GripperModel) -> np.ndarray:
    """Reference places of the points that feel the food."""
    near = made.contact.near(made.model.u.x.array)
    nodes = made.contact.points.nodes[near.rows]
    return np.asarray(made.model.u.function_space.tabulate_dof_coordinates()[nodes])


def test_forces_on_the_object_are_those_of_the_potential(touching: GripperModel) -> None:
    """Sums by finger against the contact's own derivative by the pose."""
    dofs = touching.model.u.x.array
    reads = GraspReadings(touching, 1.0)
    rubbed = touching.rubbing.forces_N(dofs)[: len(touching.contact.touching.nodes)].sum(axis=0)
    pressed = touching.contact.load_N(dofs)[:3]
    np.testing.assert_allclose(reads.on_object_N().sum(axis=0), pressed + rubbed, atol=1e-12)
    # the rows of nodes and body together move nothing: friction is between them
    rows = touching.rubbing.forces_N(dofs)
    count = len(touching.contact.touching.nodes)
    np.testing.assert_allclose(rows[:count].sum(axis=0), -rows[count], atol=1e-12)


def test_fingers_stand_where_they_should(touching: GripperModel) -> None:
    """Tips hang down in a row, skins face the block, and no two fingers meet."""
    placed = touching.contact.points.rest
    which = touching.placement.which(
        touching.model.u.function_space.tabulate_dof_coordinates()[touching.contact.points.nodes]
    )
    for i, stand in enumerate(touching.stands):
        mine = placed[which == i]
        assert mine[:, 2].max() == pytest.approx(stand.origin_mm[2])
        assert mine[:, 2].min() == pytest.approx(4.0)
        inner = (mine[:, :2] @ stand.outward).min()
        assert inner == pytest.approx(stand.origin_mm[:2] @ stand.outward)
    assert touching.finger.contact is not None
    np.testing.assert_allclose(GraspReadings(touching, 1.0).angles_deg(), 0, atol=0.5)


GRASP = ("food.friction=0.5", "gripper.lift_mm=6", "gripper.step_s=0.2")


def grasped(*overrides: str, out: Path | None = None) -> Result:
    """A short gripper's grasp."""
    config = small.short(*FOOD, *GRASP, "experiment.step_kPa=50", *overrides)
    return run("grasp", config, out=out, comm=MPI.COMM_SELF)


def test_a_light_block_is_picked_up(tmp_path: Path) -> None:
    """Momentum is balanced, nothing interpenetrates, left and right are mirror images."""
    result = grasped("experiment.max_pressure_kPa=100", "food.density_kg_m3=300", out=tmp_path)
    assert result.failure is None
    assert result.outcome is not None
    print(result.outcome)
    assert result.outcome.kind is Kind.PICKED_UP
    last = result.rows[-1]
    assert last["momentum_error_N"] < 1e-4
    weight = 9.81 * 300e-9 * 14 * 30 * 24
    lifted = sum(last[f"lift_{letter}_N"] for letter in "ABC")
    assert lifted == pytest.approx(weight, rel=0.02)
    assert last["table_N"] == pytest.approx(0, abs=1e-12)
    assert last["normal_B_N"] == pytest.approx(last["normal_C_N"], rel=0.02)
    assert last["angle_B_deg"] == pytest.approx(last["angle_C_deg"], abs=0.2)
    assert abs(last["object_y_mm"]) < 0.1
    friction = result.column("friction_mJ")
    assert (np.diff(friction) >= 0).all()
    # implicit Euler's damping, and trapezoids under p(V): works are those of steps of 10 kPa
    print("energy", last["pressure_mJ"], last["energy_error_mJ"])
    assert last["pressure_mJ"] > 0
    assert abs(last["energy_error_mJ"]) < 0.01 * last["pressure_mJ"]
    assert 0 < last["force_closure"] <= 1
    assert (tmp_path / "run.json").exists()


def test_without_pressure_it_stays_on_the_table() -> None:
    result = grasped("experiment.max_pressure_kPa=1", "experiment.step_kPa=1")
    assert result.outcome is not None
    assert result.outcome.kind is Kind.NOT_LIFTED
    assert result.rows[-1]["object_z_mm"] < result.rows[0]["object_z_mm"] - 5.9


def test_a_gripper_that_cannot_stand_is_refused() -> None:
    with pytest.raises(ConfigError, match="finger B and finger C intersect"):
        grasped("gripper.W_mm=5")
