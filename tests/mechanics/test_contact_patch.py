"""Contact patch test: two blocks pressed together carry the same uniform pressure."""

from __future__ import annotations

import numpy as np
import pytest
from support import bodies
from support.stacks import NU, PUSH, TOP, WIDTH, is_upper, stacked

from dolfingrip.config import Solver
from dolfingrip.mechanics.newton.newton import Newton

SEED = 11


@pytest.mark.parametrize(("lower", "upper"), [(3, 3), (3, 4)], ids=["matching", "not matching"])
def test_blocks_pressed_together(lower: int, upper: int) -> None:
    """The force is that of two bars in series with the gap, and spreads evenly.

    Bars with free sides under the stress E ε, ε = (push − closing of the gap)/2 = 0.5 %, where
    finite strain changes E ε and ν ε by less than 1 %. Where vertices of one face meet no
    vertices of the other, a barrier is uneven by one and a half of its own compression at most:
    vertices near edges are pushed by several pairs, the price of forces that never jump.
    """
    blocks = stacked(lower, upper)
    for axis in (0, 1, 2):
        blocks.hold(bodies.plane(axis, 0.0), axis)
    blocks.hold(bodies.plane(2, TOP), 2)
    z = blocks.nodes[:, 2]
    blocks.displace(np.where(is_upper(blocks.nodes), -PUSH, 0.0)[:, None] * [0, 0, 1])
    assert Newton(blocks.model, Solver(rtol=1e-9, max_iterations=60)).solve().converged

    u = blocks.displacement()
    below, above = np.isclose(z, 1.0), np.isclose(z, 1 + WIDTH)
    closing = u[below, 2].mean() - u[above, 2].mean()
    young = 2 * float(blocks.mu.value) * (1 + NU)
    strain = (PUSH - closing) / 2
    forces = blocks.gradient()
    ends = [forces[np.isclose(z, level), 2].sum() for level in (0.0, TOP)]
    side = np.isclose(blocks.nodes[:, 0], 1.0)
    print(
        "force",
        ends,
        "bars",
        young * strain,
        "gap closed by",
        closing,
        "uneven",
        np.ptp(u[below, 2]),
        np.ptp(u[above, 2]),
        "sides",
        u[side, 0].min() / strain,
        u[side, 0].max() / strain,
    )
    assert ends[0] == pytest.approx(-ends[1], rel=1e-6)
    assert abs(ends[0]) == pytest.approx(young * strain, rel=0.01)
    assert 0.0 < closing < 0.05 * WIDTH
    assert max(np.ptp(u[below, 2]), np.ptp(u[above, 2])) < 1.5 * closing
    assert u[side, 0].mean() == pytest.approx(NU * strain, rel=0.01)


def test_edges_on_one_line_do_not_cross() -> None:
    """Corners of the cubes, one above the other, push apart however rounding turns them.

    Taken for edges that cross, the two on one line have a distance of 0 and an infinite force.
    """
    blocks = stacked(3, 3)
    contact = blocks.contact
    assert contact is not None
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    closer = is_upper(blocks.nodes)[:, None] * [0, 0, -PUSH / 5]
    for size in np.geomspace(1e-10, 1e-6, 200):
        # the faces x = 0 stay plane, as on a plane of symmetry
        turned = rng.uniform(-size, size, blocks.nodes.shape) * (blocks.nodes > 1e-9)
        blocks.displace(closer + turned)
        assert np.isfinite(contact.gradient(blocks.u.x.array)).all()
