"""Coulomb friction on the barrier's pairs: two cubes that are pressed together and sheared."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from support import taylor
from support.frictional import (
    MU,
    SEED,
    SLIP,
    frictional,
    go,
    normal_N,
    on_upper,
    pressed,
    slid,
    slips,
)
from support.stacks import PUSH

STACKS = pytest.mark.parametrize(
    ("lower", "upper", "turn_rad"),
    [(3, 3, 0.0), (3, 4, 0.0), (3, 4, 0.3)],
    ids=["matching", "not matching", "turned"],
)


@STACKS
def test_normal_forces_are_the_barriers(lower: int, upper: int, turn_rad: float) -> None:
    """Their sum on a body, that of nearly parallel edges included, is the barrier's force."""
    blocks = pressed(lower, upper, turn_rad)
    contact = blocks.contact
    assert contact is not None
    found = contact.tangential(blocks.u.x.array)
    assert (found.normal_N > 0).all()
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1, rtol=1e-12)
    np.testing.assert_allclose(
        -on_upper(blocks, found.pressing_N()),
        on_upper(blocks, contact.gradient(blocks.u.x.array)),
        atol=1e-12 * found.normal_N.sum(),
    )
    assert len(np.unique(found.keys, axis=0)) == len(found.keys)
    # a rigid motion of all is no relative displacement
    still = found.slip(np.tile([0.3, -0.2, 0.1], (len(contact.surface.nodes), 1)))
    np.testing.assert_allclose(still, 0, atol=1e-13)


@pytest.mark.parametrize(
    ("lower", "upper", "turn_rad", "within"),
    [
        (3, 3, 0.0, 1e-6),
        (3, 4, 0.0, 1e-6),
        # at corners that hang over the normals are askew
        (3, 4, 0.3, 0.01),
    ],
    ids=["matching", "not matching", "turned"],
)
def test_sliding_takes_the_coefficient_times_the_normal_force(
    lower: int, upper: int, turn_rad: float, within: float
) -> None:
    blocks = pressed(lower, upper, turn_rad)
    friction, normal = frictional(blocks), normal_N(blocks)
    assert normal > 0
    way = np.array([0.6, -0.8, 0.0])
    for slip in (2 * SLIP, 20 * SLIP):
        dofs = slid(blocks, slip * way)
        forces = friction.forces_N(dofs)
        np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-12)
        np.testing.assert_allclose(
            on_upper(blocks, forces), MU * normal * way, atol=within * MU * normal
        )
        loss = friction.dissipated_mJ(dofs)
        assert loss == pytest.approx(MU * normal * (slip - SLIP), rel=2 * within)


def test_below_the_slip_it_is_a_spring_that_remembers() -> None:
    """μN (2t − t²), t = s/ε, s summed over the steps that stuck: Li et al. 2020, eq. 13."""
    blocks = pressed(3, 4)
    friction, full = frictional(blocks), MU * normal_N(blocks)
    way = np.array([1.0, 0.0, 0.0])
    t = 0.0
    for step in (0.3, 0.2, 0.4, -0.5, -0.9, -0.4):
        t += step
        dofs = slid(blocks, step * SLIP * way)
        force = on_upper(blocks, friction.forces_N(dofs))[0]
        stretch = min(abs(t), 1.0)
        assert force == pytest.approx(np.sign(t) * full * (2 * stretch - stretch**2), rel=1e-6)
        assert friction.dissipated_mJ(dofs) == pytest.approx(0.0, abs=1e-9 * full * SLIP)
        go(blocks, dofs, update=False)
    assert t == pytest.approx(-0.9)
    # it slides as far as it likes, and springs back from there
    go(blocks, slid(blocks, -7.3 * SLIP * way), update=False)
    dofs = slid(blocks, 0.6 * SLIP * way)
    force = on_upper(blocks, friction.forces_N(dofs))[0]
    assert force == pytest.approx(-full * (2 * 0.4 - 0.4**2), rel=1e-6)


def test_a_pair_that_replaces_another_remembers_for_it() -> None:
    """The upper cube slides over the lower one's triangles in steps that are short against ε."""
    blocks = pressed(3, 4, 0.3)
    friction = frictional(blocks, slip_mm=0.05)
    way = np.array([0.6, -0.8, 0.0])
    keys, forces = [], []
    for _ in range(24):
        go(blocks, slid(blocks, 0.005 * way))
        keys.append({tuple(key) for key in friction.contact.tangential(blocks.u.x.array).keys})
        force = on_upper(blocks, friction.forces_N(blocks.u.x.array))
        forces.append(force @ way / (MU * normal_N(blocks)))
    print("shares of the limit", np.round(forces, 3))
    replaced = [len(now - before) / len(now) for before, now in pairwise(keys[12:])]
    assert max(replaced) > 0.05
    assert len(keys[-1] - keys[11]) > 0.3 * len(keys[-1])
    # pairs at corners that hang over rub askew
    assert min(forces[12:]) > 0.97


@pytest.mark.parametrize("before", [False, True], ids=["first step", "with memory"])
def test_derivatives(before: bool) -> None:
    """Value to gradient to Hessian, in the middle of a slip that differs from point to point."""
    blocks = pressed(3, 4, 0.3)
    friction = frictional(blocks)
    there = slips(blocks)
    if before:
        go(blocks, there[1])
    start = there[0]
    w = np.random.default_rng(SEED + 1).uniform(-1, 1, start.shape)
    surface = friction.contact.touching
    w_nodes = surface.at_nodes(w)
    slope = float(np.vdot(friction.forces_N(start), w_nodes))
    steps = 0.05 * SLIP
    assert taylor.rates(lambda e: friction.value(start + e * w), slope, steps).min() > 1.9
    hessian = friction.hessian(start)
    slopes = (hessian @ w_nodes.ravel()).reshape(-1, 3)
    assert taylor.rates(lambda e: friction.forces_N(start + e * w), slopes, steps).min() > 1.9
    dense = hessian.toarray()
    np.testing.assert_allclose(dense, dense.T, atol=1e-12 * abs(dense).max())
    assert np.linalg.eigvalsh(dense).min() > -1e-12 * abs(dense).max()


@STACKS
def test_normal_forces_rise_as_bodies_come_nearer(lower: int, upper: int, turn_rad: float) -> None:
    """As a body moves as a whole, so that neither closest points nor mollifiers change at first."""
    blocks = pressed(lower, upper, turn_rad)
    contact = blocks.contact
    assert contact is not None
    start = contact.tangential(blocks.u.x.array)
    way = np.array([0.0, 0.0, 1.0])
    before = contact.touching.at_nodes(blocks.u.x.array)
    moved = contact.touching.at_nodes(slid(blocks, 1e-6 * way)) - before
    rise = start.pressed_more_N(moved, contact.facing(np.zeros(0)))
    there, back = (contact.tangential(slid(blocks, by * way)) for by in (1e-6, -1e-6))
    np.testing.assert_array_equal(there.keys, back.keys)
    np.testing.assert_allclose(
        rise, (there.normal_N - back.normal_N) / 2, atol=2e-3 * np.abs(rise).max()
    )
    assert (rise < 0).any()


def test_without_a_coefficient_it_does_nothing() -> None:
    blocks = pressed(3, 4, 0.3)
    friction = frictional(blocks, coefficient=0.0)
    dofs = slips(blocks)[0]
    assert not friction.forces_N(dofs).any()
    assert friction.hessian(dofs).nnz == 0
    assert friction.value(dofs) == 0.0


@pytest.mark.parametrize("turn_rad", [0.0, 0.3])
def test_no_step_gives_work_back(turn_rad: float) -> None:
    """Work done in each accepted step, however irregular, is stored or taken, never given."""
    blocks = pressed(3, 4, turn_rad)
    friction = frictional(blocks)
    there, taken = slips(blocks), 0.0
    for dofs in [*there, *there[::-1]]:
        before = blocks.u.x.array.copy()
        blocks.u.x.array[:] = dofs
        blocks.model.update_lagged()
        stored, loss = friction.value(before), friction.dissipated_mJ(dofs)
        work = friction.value(dofs) - stored
        assert loss >= 0
        moved = friction.contact.touching.at_nodes(dofs - before)
        assert np.vdot(friction.forces_N(dofs), moved) >= work
        blocks.model.accept_step()
        assert work - (friction.value(dofs) - stored) == pytest.approx(loss, rel=1e-9, abs=1e-12)
        taken += loss
    assert taken > 0.1 * MU * normal_N(blocks) * SLIP


def test_a_restored_model_rubs_as_before() -> None:
    blocks = pressed(3, 3)
    friction = frictional(blocks)
    go(blocks, slid(blocks, np.array([0, SLIP / 3, 0])))
    good = blocks.model.state()
    dofs, expected = slid(blocks, np.array([SLIP / 2, 0, 0])), None
    for restored in (False, True):
        if restored:
            blocks.model.restore(good)
        found = friction.forces_N(dofs)
        expected = found if expected is None else expected
        np.testing.assert_array_equal(found, expected)
        assert found.any()
        go(blocks, slid(blocks, np.array([0, 0, -PUSH / 3])))  # other pairs, another memory
        assert not np.array_equal(friction.forces_N(dofs), expected)
