"""Coulomb friction on the barrier's pairs: two cubes that are pressed together and sheared."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from dolfinx import fem
from mechanics import bodies, taylor
from mechanics.stacks import PUSH, TOP, WIDTH, is_upper, stacked
from petsc4py import PETSc

from dolfingrip.config import Solver
from dolfingrip.mechanics.contact.friction import Friction
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.refreshing import DRIFTS

SEED = 23
MU = 0.5
SLIP = 1e-3
"""mm; a twentieth of the gap between the cubes."""


def rubbing(blocks: bodies.Body, coefficient: float = MU, slip_mm: float = SLIP) -> Friction:
    """Give ``blocks`` friction, from where they stand."""
    assert blocks.contact is not None
    mu = fem.Constant(blocks.model.domain.mesh, PETSc.ScalarType(coefficient))
    friction = Friction(blocks.contact, blocks.u, mu, slip_mm)
    blocks.model.terms = [blocks.plate, blocks.contact, friction]
    return friction


def pressed(lower: int, upper: int, turn_rad: float = 0.0) -> bodies.Body:
    """Rigid cubes half a barrier apart, the upper one turned about the middle."""
    blocks = stacked(lower, upper)
    above = is_upper(blocks.nodes)
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    arm = blocks.nodes[:, :2] - 0.5
    move = np.column_stack([arm @ [[c, s], [-s, c]] - arm, np.full(len(above), -PUSH)])
    blocks.displace(np.where(above[:, None], move, 0.0))
    return blocks


def on_upper(blocks: bodies.Body, forces: np.ndarray) -> np.ndarray:
    """(3,) sum over the upper cube of (n, 3) forces at the surface's nodes."""
    assert blocks.contact is not None
    surface = blocks.contact.surface
    return np.asarray(forces[is_upper(surface.rest)].sum(axis=0))


def normal_N(blocks: bodies.Body) -> float:
    """Force between the cubes that the barrier takes."""
    assert blocks.contact is not None
    return -float(on_upper(blocks, blocks.contact.gradient(blocks.u.x.array))[2])


def slid(blocks: bodies.Body, by: np.ndarray) -> np.ndarray:
    """Dofs with the upper cube moved on by (3,) ``by``."""
    return (blocks.displacement() + is_upper(blocks.nodes)[:, None] * by).ravel()


def slips(blocks: bodies.Body) -> list[np.ndarray]:
    """Irregular displacements of both cubes, of about the slip at which friction is full."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    shape = blocks.nodes.shape
    start = blocks.displacement()
    return [(start + SLIP * rng.uniform(-1, 1, shape)).ravel() for _ in range(6)]


def go(blocks: bodies.Body, dofs: np.ndarray, *, refresh: bool = True) -> None:
    """Accept ``dofs`` as the end of a load step."""
    blocks.u.x.array[:] = dofs
    if refresh:
        blocks.model.refresh()
    blocks.model.accept_step()


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
    friction, normal = rubbing(blocks), normal_N(blocks)
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
    friction, full = rubbing(blocks), MU * normal_N(blocks)
    way = np.array([1.0, 0.0, 0.0])
    t = 0.0
    for step in (0.3, 0.2, 0.4, -0.5, -0.9, -0.4):
        t += step
        dofs = slid(blocks, step * SLIP * way)
        force = on_upper(blocks, friction.forces_N(dofs))[0]
        stretch = min(abs(t), 1.0)
        assert force == pytest.approx(np.sign(t) * full * (2 * stretch - stretch**2), rel=1e-6)
        assert friction.dissipated_mJ(dofs) == pytest.approx(0.0, abs=1e-9 * full * SLIP)
        go(blocks, dofs, refresh=False)
    assert t == pytest.approx(-0.9)
    # it slides as far as it likes, and springs back from there
    go(blocks, slid(blocks, -7.3 * SLIP * way), refresh=False)
    dofs = slid(blocks, 0.6 * SLIP * way)
    force = on_upper(blocks, friction.forces_N(dofs))[0]
    assert force == pytest.approx(-full * (2 * 0.4 - 0.4**2), rel=1e-6)


def test_a_pair_that_replaces_another_remembers_for_it() -> None:
    """The upper cube slides over the lower one's triangles in steps that are short against ε."""
    blocks = pressed(3, 4, 0.3)
    friction = rubbing(blocks, slip_mm=0.05)
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
    friction = rubbing(blocks)
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


def test_the_derivative_by_the_coefficient() -> None:
    """The gradient is linear in μ, so that a difference is exact."""
    blocks = pressed(3, 4, 0.3)
    friction = rubbing(blocks)
    dofs = slips(blocks)[0]

    def gradient(mu: float) -> np.ndarray:
        friction.coefficient.value = mu
        found = Gradient(blocks.model.unknowns)
        friction.add_gradient(dofs, found)
        return found.array

    change = (gradient(0.8) - gradient(0.2)) / 0.6
    rate, none = Gradient(blocks.model.unknowns), Gradient(blocks.model.unknowns)
    friction.add_gradient_by(friction.coefficient, dofs, rate)
    friction.add_gradient_by(blocks.mu, dofs, none)
    np.testing.assert_allclose(rate.array, change, atol=1e-12 * abs(change).max())
    assert rate.array.any()
    assert not none.array.any()


def test_without_a_coefficient_it_does_nothing() -> None:
    blocks = pressed(3, 4, 0.3)
    friction = rubbing(blocks, coefficient=0.0)
    dofs = slips(blocks)[0]
    assert not friction.forces_N(dofs).any()
    assert friction.hessian(dofs).nnz == 0
    assert friction.value(dofs) == 0.0


@pytest.mark.parametrize("turn_rad", [0.0, 0.3])
def test_no_step_gives_work_back(turn_rad: float) -> None:
    """Work done in each accepted step, however irregular, is stored or taken, never given."""
    blocks = pressed(3, 4, turn_rad)
    friction = rubbing(blocks)
    there, taken = slips(blocks), 0.0
    for dofs in [*there, *there[::-1]]:
        before = blocks.u.x.array.copy()
        blocks.u.x.array[:] = dofs
        blocks.model.refresh()
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
    friction = rubbing(blocks)
    go(blocks, slid(blocks, np.array([0, SLIP / 3, 0])))
    good = blocks.model.state().copy()
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


# -- solved ----------------------------------------------------------------------------------------


class Shear:
    """Elastic cubes on one another, held at the bottom and at the top, which is moved."""

    def __init__(self) -> None:
        self.blocks = blocks = stacked(3, 4)
        for level in (0.0, TOP):
            blocks.hold(bodies.plane(2, level))
        self.newton = Newton(blocks.model, Solver(rtol=1e-9, atol_N=1e-12, max_iterations=60))
        blocks.displace(is_upper(blocks.nodes)[:, None] * [0, 0, -PUSH])
        assert self.newton.solve().converged
        self.friction = rubbing(blocks)
        z = blocks.nodes[:, 2]
        self.top, self.below, self.above = (np.isclose(z, at) for at in (TOP, 1.0, 1 + WIDTH))

    def full_N(self) -> float:
        """μN at present."""
        return MU * normal_N(self.blocks)

    def step(self, by: float) -> float:
        """Slip (mm) of the faces as the top moves by ``by`` along x in a step."""
        before = self.blocks.displacement()
        self.blocks.displace(before + self.top[:, None] * [by, 0, 0])
        solve = self.newton.solve()
        assert solve.converged, solve
        moved = (self.blocks.displacement() - before)[:, 0]
        self.force = float(self.blocks.gradient()[self.top, 0].sum())
        forces = self.friction.forces_N(self.blocks.u.x.array)
        self.rubs = float(on_upper(self.blocks, forces)[0])
        self.blocks.model.accept_step()
        return float(moved[self.above].mean() - moved[self.below].mean())


def test_cubes_stick_then_slide() -> None:
    """Stuck below μN, at ±μN beyond, N the present normal force, with plain Newton iterations.

    Sheared by s in all, two cubes bear at most G s / 2.
    """
    cubes = Shear()
    full = cubes.full_N()
    slip = cubes.step(0.4 * full / float(cubes.blocks.mu.value))
    assert 0 < cubes.force < 0.2 * full
    assert 0 < cubes.rubs < 0.2 * full
    assert 0 < slip < 0.1 * SLIP
    for way in (1, -1):
        slips_mm = [cubes.step(way * 0.075) for _ in range(4)]
        full = cubes.full_N()
        print("slid", slips_mm, cubes.rubs, cubes.force, "of", full)
        assert slips_mm[-1] * way > 10 * SLIP
        # normal forces are held where they drift by less, and the faces' rims rub askew
        assert cubes.rubs == pytest.approx(way * full, rel=1.5 * DRIFTS)
        assert cubes.force == pytest.approx(cubes.rubs, rel=0.03)


def test_a_load_that_rests_moves_nothing() -> None:
    """Sheared to 0.9 of what they bear at most, then at rest in 50 steps of different length."""
    cubes = Shear()
    cubes.step(0.5 * cubes.full_N() / float(cubes.blocks.mu.value))
    while cubes.rubs < 0.9 * cubes.full_N():
        cubes.step(0.1 * cubes.full_N() / float(cubes.blocks.mu.value))
    assert cubes.rubs < cubes.full_N()
    start, time_s = cubes.blocks.displacement(), 0.0
    for length_s in np.random.default_rng(SEED).uniform(1e-3, 10, 50):
        time_s += float(length_s)
        cubes.blocks.model.prescribe({"time_s": time_s})
        cubes.step(0.0)
    assert np.abs(cubes.blocks.displacement() - start).max() < 1e-9


def test_half_the_step_leads_to_the_same() -> None:
    """Through sticking, sliding of the rim, of all, and back."""
    found = []
    for parts in (1, 2, 4):
        cubes = Shear()
        unit = cubes.full_N() / float(cubes.blocks.mu.value)
        forces = []
        for by in (0.5, 1.0, 1.5, 2.0, -1.0, -1.5):
            for _ in range(parts):
                cubes.step(by * unit / parts)
            forces.append(cubes.force)
        found.append(np.array(forces) / cubes.full_N())
        print(found[-1], cubes.newton.iterations)
    for coarse in found[:-1]:
        np.testing.assert_allclose(coarse, found[-1], rtol=0, atol=1e-3)
