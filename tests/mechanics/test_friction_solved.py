"""Elastic cubes that stick to one another and slide, solved for."""

from __future__ import annotations

import numpy as np
import pytest
from support import bodies
from support.frictional import MU, SEED, SLIP, frictional, normal_N, on_upper
from support.stacks import PUSH, TOP, WIDTH, is_upper, stacked

from dolfingrip.config import Solver
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.policy import LagPolicy


class Shear:
    """Elastic cubes on one another, held at the bottom and at the top, which is moved."""

    def __init__(self) -> None:
        self.blocks = blocks = stacked(3, 4)
        for level in (0.0, TOP):
            blocks.hold(bodies.plane(2, level))
        self.newton = Newton(blocks.model, Solver(rtol=1e-9, atol_N=1e-12, max_iterations=60))
        blocks.displace(is_upper(blocks.nodes)[:, None] * [0, 0, -PUSH])
        assert self.newton.solve().converged
        self.friction = frictional(blocks)
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
        # normal forces are held where they lag by less, and the faces' rims rub askew
        assert cubes.rubs == pytest.approx(way * full, rel=1.5 * LagPolicy().tolerance)
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


@pytest.mark.slow
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
        print(found[-1], cubes.newton.counts.iterations)
    for coarse in found[:-1]:
        np.testing.assert_allclose(coarse, found[-1], rtol=0, atol=1e-3)
