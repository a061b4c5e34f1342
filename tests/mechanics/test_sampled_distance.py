"""Signed distances of shapes that are not convex, and what step bounds rest on."""

from __future__ import annotations

import numpy as np
import pytest
from support import taylor

from dolfingrip.mechanics.contact.distance import BentCapsule, Capsule, SignedDistance
from dolfingrip.mechanics.contact.sampled_distance import BEZIER, SampledDistance, b_splines

SEED = 5
BENT = BentCapsule(0.5, 1.5, 1.2, 0.1)


def two_balls(points: np.ndarray) -> np.ndarray:
    """Distance from two balls that overlap: dented between them."""
    apart = np.abs(points) * [1, 0, 0] + points * [0, 1, 1] - [0.6, 0, 0]
    return np.linalg.norm(apart, axis=1) - 0.8


SAMPLED = SampledDistance.of(two_balls, np.full(3, -2.5), np.full(3, 2.5), 0.25)


def outside(shape: SignedDistance, farthest_mm: float, count: int = 400) -> np.ndarray:
    """Points outside, no farther than that."""
    points = np.random.default_rng(SEED).uniform(-2.4, 2.4, (30 * count, 3))
    value = shape.at(points).value
    return points[(value > 0.01) & (value < farthest_mm)][:count]


@pytest.mark.parametrize("shape", [BENT, SAMPLED], ids=["bent", "sampled"])
def test_derivatives(shape: SignedDistance) -> None:
    print("seed", SEED)
    points = outside(shape, 0.3, 40)
    way = np.random.default_rng(SEED + 1).uniform(-1, 1, points.shape)
    found = shape.at(points)
    slope = np.einsum("ni,ni->n", found.gradient, way)
    curve = np.einsum("nij,nj->ni", found.hessian, way)
    assert taylor.rates(lambda e: shape.at(points + e * way).value, slope, 1e-3).min() > 1.9
    assert taylor.rates(lambda e: shape.at(points + e * way).gradient, curve, 1e-3).min() > 1.9


@pytest.mark.parametrize("shape", [BENT, SAMPLED], ids=["bent", "sampled"])
def test_bounds_hold_and_are_needed(shape: SignedDistance) -> None:
    """Slope and concavity are nowhere passed; the shape is concave somewhere."""
    bounds = shape.bounds
    found = shape.at(outside(shape, 2.0, 2000))
    assert np.linalg.norm(found.gradient, axis=1).max() <= bounds.slope + 1e-12
    within = found.value <= bounds.reach_mm
    assert within.sum() > 100
    least = np.linalg.eigvalsh(found.hessian[within]).min()
    print("most concave", -least, "bound", bounds.concavity_per_mm, "slope", bounds.slope)
    assert -bounds.concavity_per_mm <= least < -0.1


def test_a_bent_capsule_is_one() -> None:
    """Against the least distance from points of its axis, closely spaced."""
    angles = np.linspace(-1, 1, 4001) * BENT.half_length_mm / BENT.bend_radius_mm
    arc = np.stack([1 - np.cos(angles), 0 * angles, np.sin(angles)], axis=1)
    arc = BENT.bend_radius_mm * arc + [BENT.place_mm, 0, 0]
    points = outside(BENT, 2.0, 200)
    apart = np.linalg.norm(points[:, None] - arc, axis=2).min(axis=1) - BENT.radius_mm
    np.testing.assert_allclose(BENT.at(points).value, apart, atol=1e-5)


def test_samples_converge() -> None:
    """The spline's values are of fourth order, its Hessian of second (de Boor, 1978, ch. V)."""
    exact = Capsule(1.3, 0.0)  # a sphere
    points = outside(exact, 0.4)
    errors = []
    for spacing in (0.2, 0.1):
        low, high = np.full(3, -2.513), np.full(3, 2.5)  # no sample at the centre
        found = SampledDistance.of(lambda x: exact.at(x).value, low, high, spacing).at(points)
        wanted = exact.at(points)
        errors.append([np.abs(a - b).max() for a, b in zip(found, wanted, strict=True)])
    rates = np.log2(np.array(errors[0]) / errors[1])
    print(errors, rates)
    assert (rates > [3.5, 2.5, 1.6]).all()


def test_beyond_the_grid_no_distance_is_too_large() -> None:
    points = np.random.default_rng(SEED).uniform(-6, 6, (500, 3))
    beyond = points[np.abs(points).max(axis=1) > 2.5]
    assert (SAMPLED.at(beyond).value <= two_balls(beyond)).all()
    assert (SAMPLED.at(beyond).value > 0).all()


def test_beyond_the_grid_the_gradient_is_the_distances() -> None:
    """Off its faces, edges and corners; it is of length 1 there."""
    rng = np.random.default_rng(SEED)
    points = rng.uniform(-6, 6, (500, 3))
    beyond = points[np.abs(points).max(axis=1) > 2.6]
    way = rng.uniform(-1, 1, beyond.shape)
    found = SAMPLED.at(beyond)
    slope = np.einsum("ni,ni->n", found.gradient, way)
    assert taylor.rates(lambda e: SAMPLED.at(beyond + e * way).value, slope, 1e-3).min() > 1.9
    np.testing.assert_allclose(np.linalg.norm(found.gradient, axis=1), 1.0, rtol=1e-12)


def test_control_points_are_those_of_the_spline() -> None:
    """The cubic's value and derivatives at the ends of a cell are its outer control points."""
    c = np.array([0.3, -1.2, 2.0, 0.7])
    ends = b_splines(np.array([0.0, 1.0])) @ c
    for order in range(3):
        np.testing.assert_allclose((BEZIER[order] @ c)[[0, 3]], ends[order], atol=1e-14)
    middle = np.array([1, 3, 3, 1]) / 8
    for order in range(3):
        at_middle = b_splines(np.array([0.5]))[order] @ c
        np.testing.assert_allclose(middle @ BEZIER[order] @ c, at_middle, atol=1e-14)


def test_a_grid_that_cuts_the_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="above 0 needed"):
        SampledDistance.of(two_balls, np.full(3, -1.0), np.full(3, 2.5), 0.25)
