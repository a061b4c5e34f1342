"""Damped solves: over a snap to the stable state beyond it, and nowhere else than plain ones."""

from __future__ import annotations

import numpy as np
import pytest
from support import bodies

from dolfingrip.config import Solver
from dolfingrip.mechanics.newton.newton import Newton

SPAN_MM, RISE_MM, THICK_MM = 20.0, 2.0, 0.5
STEP = 1e-4
"""N/mm³, added to the weight."""
SETTINGS = Solver(rtol=1e-9, max_iterations=30)


@pytest.fixture(scope="module")
def arch() -> bodies.Body:
    """A clamped shallow arch in the form of a cosine, one element thick."""
    solid = bodies.box((20, 1, 1), (SPAN_MM, 1.0, THICK_MM))
    x = solid.geometry.x
    x[:, 2] += RISE_MM / 2 * (1 - np.cos(2 * np.pi * x[:, 0] / SPAN_MM))
    body = bodies.body(bodies.domain(solid, {}), 2)
    for end in (0.0, SPAN_MM):
        body.hold(bodies.plane(0, end))
    return body


def load(arch: bodies.Body, force: float) -> None:
    """Weight ``force`` (N/mm³) downwards on the undeformed arch."""
    arch.displace(np.zeros_like(arch.nodes))
    arch.body_force.x.array.reshape(-1, 3)[:, 2] = -force


def crown_mm(arch: bodies.Body) -> float:
    """How far the middle has come down."""
    middle = np.isclose(arch.nodes[:, 0], SPAN_MM / 2)
    return float(-arch.displacement()[middle, 2].mean())


def test_snaps_to_the_far_side(arch: bodies.Body) -> None:
    """A weight beyond the arch's limit load takes it to a minimum of Π below the supports.

    In small steps of the weight plain solves end earlier, with the crown still above them.
    """
    newton = Newton(arch.model, SETTINGS)
    load(arch, 0.0)
    force, reached = 0.0, True
    while reached and force < 100 * STEP:
        down, force = crown_mm(arch), force + STEP
        arch.body_force.x.array.reshape(-1, 3)[:, 2] = -force
        reached = newton.solve().converged
    print(f"{force - STEP:.2g} N/mm³ are borne, the crown {down:.3f} mm down")
    assert not reached
    assert 0.1 * RISE_MM < down < 0.5 * RISE_MM

    load(arch, force)
    solve = newton.solve(damped=True)
    print("snapped", solve, f"{crown_mm(arch):.3f} mm down")
    assert solve.converged
    assert newton.counts.damped == 1
    assert crown_mm(arch) > 1.5 * RISE_MM
    # and Π rises along any small change
    energy, state = arch.energy(), arch.displacement()
    rng = np.random.default_rng(3)
    free = (arch.nodes[:, :1] > 1e-9) & (arch.nodes[:, :1] < SPAN_MM - 1e-9)
    for _ in range(10):
        arch.displace(state + 1e-3 * free * rng.uniform(-1, 1, state.shape))
        assert arch.energy() > energy


def test_arrives_where_a_plain_solve_does(arch: bodies.Body) -> None:
    """Below the snap the state is the same."""
    found = []
    for damped in (False, True):
        load(arch, 3 * STEP)
        assert Newton(arch.model, SETTINGS).solve(damped=damped).converged
        found.append(arch.displacement())
    assert abs(found[0]).max() > 0.01
    np.testing.assert_allclose(found[1], found[0], atol=1e-8)
