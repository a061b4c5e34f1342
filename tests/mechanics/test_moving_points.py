"""Points along a step in which a body turns and moves: slopes, and the bounds of step lengths."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.mechanics.contact.distance import (
    BentCapsule,
    Bounds,
    MovingPoints,
    Path,
    Plane,
    reach,
)

SEED = 11
PARTS = np.linspace(0.05, 0.95, 7)
STEP = 1e-4
AXES = [Plane((1.0, 0.0, 0.0)), Plane((0.0, 1.0, 0.0)), Plane((0.0, 0.0, 1.0))]
there_and_back = pytest.mark.parametrize("back", [False, True], ids=["there", "back"])


def moving(*, back: bool, turn: float = 1.0, drift: float = 1.0, arm: float = 1.0) -> MovingPoints:
    """Points of any motion, turned before."""
    rng = np.random.default_rng(SEED)
    arms, drifts = (size * rng.uniform(-1, 1, (30, 3)) for size in (arm, drift))
    place, shift, theta, turning = rng.uniform(-1, 1, (4, 3))
    return MovingPoints(arms, drifts, place, shift, theta, turn * turning, back)


def places(points: MovingPoints, part: float) -> np.ndarray:
    """Where (n, 3) the shape sees the points."""
    return np.stack([points.at(part, axis).distance for axis in AXES], axis=1)


@there_and_back
def test_slopes_are_those_of_distances(back: bool) -> None:
    print("seed", SEED)
    points = moving(back=back)
    shape = BentCapsule(0.5, 1.5, 1.2, 0.1)
    for part in PARTS:
        ends = [points.at(part + step, shape).distance for step in (STEP, -STEP)]
        difference = (ends[0] - ends[1]) / (2 * STEP)
        np.testing.assert_allclose(points.at(part, shape).slope, difference, atol=1e-5)


@there_and_back
@pytest.mark.parametrize(
    ("turn", "drift", "arm"),
    [(1.0, 1.0, 1.0), (3.0, 0.0, 1.0), (0.1, 1.0, 0.0), (0.0, 1.0, 1.0)],
    ids=["any", "a turn", "a drift that turns a little", "a drift"],
)
def test_no_point_is_faster_or_bends_more(
    back: bool, turn: float, drift: float, arm: float
) -> None:
    """At no place of the rest of a step; what turns a little as it drifts bends nearly so much."""
    points = moving(back=back, turn=turn, drift=drift, arm=arm)
    bound = points.at(0.0, AXES[0])
    closest = 0.0
    for part in PARTS:
        before, now, after = (places(points, part + step) for step in (-STEP, 0.0, STEP))
        speed = np.linalg.norm(after - before, axis=1) / (2 * STEP)
        bend = np.linalg.norm(after - 2 * now + before, axis=1) / STEP**2
        assert (speed <= bound.fastest + 1e-6).all()
        assert (bend <= bound.bend + 1e-6).all()
        closest = max(closest, float((bend / np.maximum(bound.bend, 1e-12)).max()))
    print("part of the bound", closest)
    if turn == 0.1:
        assert closest > 0.6


@pytest.mark.filterwarnings("error")
def test_a_point_that_stands_still_bounds_no_step() -> None:
    """A shape that is curved inwards bounds how far points may go; these go nowhere."""
    still = np.zeros(2)
    path = Path(np.array([0.3, 5.0]), still, still, still)
    assert reach(lambda part: path, Bounds(1.0, 2.0, 0.5)) == 1.0
