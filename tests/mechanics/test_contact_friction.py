"""Coulomb friction on the barrier's pairs: two cubes that are pressed together and sheared."""

from __future__ import annotations

import numpy as np
import pytest
from mechanics import bodies, taylor
from mechanics.stacks import PUSH, STIFFNESS, TOP, WIDTH, is_upper, stacked

from dolfingrip.config import Solver
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.friction import FrictionalContact
from dolfingrip.mechanics.newton.newton import Newton

SEED = 23
MU = 0.5
SLIP = 1e-3
"""mm; a twentieth of the gap between the cubes."""


def rubbing(blocks: bodies.Body, coefficient: float = MU) -> FrictionalContact:
    """Give ``blocks`` friction, from where they stand."""
    contact = blocks.contact
    assert contact is not None
    made = FrictionalContact(
        contact.surface, WIDTH, STIFFNESS, u=blocks.u, coefficient=coefficient, slip_mm=SLIP
    )
    blocks.touch(made)
    return made


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


@pytest.mark.parametrize(
    ("lower", "upper", "turn_rad", "within"),
    [
        (3, 3, 0.0, 1e-6),
        (3, 4, 0.0, 1e-6),
        # edges that are nearly parallel repel less than their friction knows (ipctk's mollifier)
        (3, 4, 0.3, 0.01),
    ],
    ids=["matching", "not matching", "turned"],
)
def test_sliding_takes_the_coefficient_times_the_normal_force(
    lower: int, upper: int, turn_rad: float, within: float
) -> None:
    blocks = pressed(lower, upper, turn_rad)
    contact = rubbing(blocks)
    normal = on_upper(blocks, BarrierContact.gradient(contact, blocks.u.x.array))[2]
    assert normal < 0
    way = np.array([0.6, -0.8, 0.0])
    for slip in (2 * SLIP, 20 * SLIP):
        forces = contact.friction_N(slid(blocks, slip * way))
        np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-12)
        np.testing.assert_allclose(
            on_upper(blocks, forces), MU * abs(normal) * way, atol=within * MU * abs(normal)
        )


def test_below_the_slip_it_is_a_spring() -> None:
    """μN (2t − t²), t = s/ε: Li et al. 2020, eq. 13."""
    blocks = pressed(3, 4)
    contact = rubbing(blocks)
    full = on_upper(blocks, contact.friction_N(slid(blocks, np.array([2 * SLIP, 0, 0]))))[0]
    assert full > 0
    for t in (0.1, 0.5, 0.9):
        force = on_upper(blocks, contact.friction_N(slid(blocks, np.array([t * SLIP, 0, 0]))))[0]
        assert force == pytest.approx(full * (2 * t - t**2), rel=1e-9)


def test_derivatives() -> None:
    """Value to gradient to Hessian, in the middle of a slip that differs from point to point."""
    blocks = pressed(3, 4, 0.3)
    contact = rubbing(blocks)
    start = slips(blocks)[0]
    w = np.random.default_rng(SEED + 1).uniform(-1, 1, start.shape)
    w_nodes = contact.surface.at_nodes(w)
    slope = float(np.vdot(contact.gradient(start), w_nodes))
    steps = 0.05 * SLIP
    assert taylor.rates(lambda e: contact.value(start + e * w), slope, steps).min() > 1.9
    hessian = contact.hessian(start)
    assert hessian is not None
    slopes = (hessian @ w_nodes.ravel()).reshape(-1, 3)
    assert taylor.rates(lambda e: contact.gradient(start + e * w), slopes, steps).min() > 1.9
    assert abs(hessian - hessian.T).max() < 1e-12 * abs(hessian).max()
    # or the barrier alone would have been tested
    assert np.linalg.norm(contact.friction_N(start)) > 0.1 * np.linalg.norm(
        BarrierContact.gradient(contact, start)
    )


def test_without_a_coefficient_it_is_the_barrier() -> None:
    blocks = pressed(3, 4, 0.3)
    plain = blocks.contact
    assert plain is not None
    contact = rubbing(blocks, coefficient=0.0)
    dofs = slips(blocks)[0]
    np.testing.assert_allclose(contact.gradient(dofs), plain.gradient(dofs), rtol=0, atol=1e-15)
    found, expected = contact.hessian(dofs), plain.hessian(dofs)
    assert found is not None
    assert expected is not None
    assert abs(found - expected).max() < 1e-13 * abs(expected).max()
    assert contact.value(dofs) == pytest.approx(plain.value(dofs), rel=1e-13)


@pytest.mark.parametrize("turn_rad", [0.0, 0.3])
def test_no_step_gives_work_back(turn_rad: float) -> None:
    """Force times slip of each accepted step, however irregular, there and back."""
    blocks = pressed(3, 4, turn_rad)
    contact = rubbing(blocks)
    there = slips(blocks)
    for dofs in [*there, *there[::-1]]:
        moved = contact.surface.at_nodes(dofs - blocks.u.x.array)
        work = float(np.vdot(contact.friction_N(dofs), moved))
        assert work >= 0.0
        blocks.u.x.array[:] = dofs
        blocks.model.accept_step()
    assert contact.friction_N(there[1]).any()


def test_a_restored_model_rubs_as_before() -> None:
    blocks = pressed(3, 3)
    contact = rubbing(blocks)
    good = blocks.model.state()
    dofs, expected = slid(blocks, np.array([SLIP / 2, 0, 0])), None
    for restored in (False, True):
        if restored:
            blocks.model.restore(good)
        found = contact.friction_N(dofs)
        expected = found if expected is None else expected
        np.testing.assert_array_equal(found, expected)
        assert found.any()
        blocks.u.x.array[:] = dofs  # accept there, where the same dofs are no slip
        blocks.model.accept_step()
        assert not contact.friction_N(dofs).any()


def test_cubes_stick_then_slide() -> None:
    """Cubes on one another, the top moved sideways and back: stuck below μN, at ±μN beyond.

    N is the normal force at the step's start. Sheared by s in all, two cubes bear at most G s / 2.
    """
    blocks = stacked(3, 4)
    for level in (0.0, TOP):
        blocks.hold(bodies.plane(2, level))
    newton = Newton(blocks.model, Solver(rtol=1e-9, atol_N=1e-12, max_iterations=60))
    z = blocks.nodes[:, 2]
    top, below, above = (np.isclose(z, level) for level in (TOP, 1.0, 1 + WIDTH))
    blocks.displace(is_upper(blocks.nodes)[:, None] * [0, 0, -PUSH])
    assert newton.solve().converged
    contact = rubbing(blocks)

    def limit() -> float:
        return MU * abs(on_upper(blocks, BarrierContact.gradient(contact, blocks.u.x.array))[2])

    def step(by: float) -> tuple[float, float, float]:
        """Friction, force at the top (N) and slip of the faces (mm) in a step along x."""
        before = blocks.displacement()
        blocks.u.x.array[:] = slid(blocks, np.array([by, 0, 0]))
        assert newton.solve(careful=True).converged  # sticking, a plain one loses its way
        friction = on_upper(blocks, contact.friction_N(blocks.u.x.array))[0]
        force = blocks.gradient()[top, 0].sum()
        moved = (blocks.displacement() - before)[:, 0]
        blocks.model.accept_step()
        return float(friction), float(force), float(moved[above].mean() - moved[below].mean())

    full = limit()
    short = 0.4 * full / float(blocks.mu.value)
    friction, force, slip = step(short)
    print("stuck", friction, force, slip, "of", full)
    assert 0 < force < 0.2 * full
    assert 0 < friction < 0.2 * full
    assert 0 < slip < 0.1 * SLIP
    for way in (1, -1):
        full = limit()
        friction, force, slip = step(way * 0.3)
        print("slid", friction, force, slip, "of", full)
        assert slip * way > 10 * SLIP
        assert friction == pytest.approx(way * full, rel=1e-3)
        # sheared cubes' faces are not quite level: the barrier's force has a part along x, too
        assert force == pytest.approx(friction, rel=0.03)
