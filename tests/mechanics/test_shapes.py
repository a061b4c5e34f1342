"""Rotations and signed distances: their derivatives by Taylor's series, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support import taylor

from dolfingrip.mechanics.contact.distance import (
    Capsule,
    Plane,
    RoundedBox,
    SignedDistance,
)
from dolfingrip.mechanics.model.pose import rotation

SEED = 17
SHAPES: list[SignedDistance] = [
    Plane((0.6, 0.0, 0.8)),
    Capsule(3.0, 0.0),
    Capsule(2.0, 4.0),
    RoundedBox((4.0, 3.0, 2.0), 0.5),
]
NAMES = ["plane", "sphere", "capsule", "box"]


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.999, 1.001, 2.5, 6.0])
def test_rotation(angle: float) -> None:
    """SciPy's matrix; derivatives of R : M by Taylor's series, also across the series' end."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    axis, m, w = rng.normal(size=3), rng.normal(size=(3, 3)), rng.normal(size=3)
    theta = angle * axis / np.linalg.norm(axis)
    found = rotation(theta)
    expected = Rotation.from_rotvec(theta).as_matrix()
    np.testing.assert_allclose(found.matrix, expected, rtol=0, atol=1e-14)

    def value(step: float) -> float:
        return float(np.vdot(rotation(theta + step * w).matrix, m))

    def slopes(step: float) -> np.ndarray:
        return rotation(theta + step * w).slopes(m)

    assert taylor.rates(value, float(found.slopes(m) @ w), 0.02).min() > 1.9
    assert taylor.rates(slopes, found.curvatures(m) @ w, 0.02).min() > 1.9
    curvatures = found.curvatures(m)
    np.testing.assert_allclose(curvatures, curvatures.T, atol=1e-14)


def outside(shape: SignedDistance) -> np.ndarray:
    """Random points up to some mm outside; none near a jump of a Hessian."""
    points = np.random.default_rng(SEED).uniform(-8, 8, (400, 3))
    value = shape.at(points).value
    return points[(value > 0.01) & (value < 5)]


@pytest.mark.parametrize("shape", SHAPES, ids=NAMES)
def test_distance(shape: SignedDistance) -> None:
    """Gradient of length 1, Hessian symmetric and without a part along it; Taylor's orders."""
    print("seed", SEED)
    points = outside(shape)
    assert len(points) > 20
    w = np.random.default_rng(SEED + 1).uniform(-1, 1, points.shape)
    found = shape.at(points)
    np.testing.assert_allclose(np.linalg.norm(found.gradient, axis=1), 1, rtol=1e-12)
    along = np.einsum("nij,nj->ni", found.hessian, found.gradient)
    np.testing.assert_allclose(along, 0, atol=1e-12)
    np.testing.assert_allclose(found.hessian, found.hessian.transpose(0, 2, 1), atol=1e-12)
    # the surface itself is where the way back by the distance leads
    foot = points - found.value[:, None] * found.gradient
    np.testing.assert_allclose(shape.at(foot).value, 0, atol=1e-12)
    if isinstance(shape, Plane):
        return
    slope = np.einsum("ni,ni->n", found.gradient, w)
    assert taylor.rates(lambda e: shape.at(points + e * w).value, slope, 1e-3).min() > 1.9
    smooth = ~_jumps(shape, points, 0.01)
    curve = np.einsum("nij,nj->ni", found.hessian, w)[smooth]
    some, ways = points[smooth], w[smooth]
    assert taylor.rates(lambda e: shape.at(some + e * ways).gradient, curve, 1e-3).min() > 1.9


def _jumps(shape: SignedDistance, points: np.ndarray, near: float) -> np.ndarray:
    """Points that a short step may lead across a jump of the Hessian."""
    if isinstance(shape, Capsule):
        return np.abs(np.abs(points[:, 2]) - shape.half_length_mm) < near
    if isinstance(shape, RoundedBox):
        core = np.asarray(shape.half_mm) - shape.radius_mm
        return np.asarray((np.abs(np.abs(points) - core) < near).any(axis=1))
    return np.zeros(len(points), dtype=bool)


def test_closed_forms() -> None:
    """Points on the axes, and at the corner of a box."""
    points = np.array([[7.0, 0, 0], [0, 7.0, 0], [0, 0, 7.0]])
    expected = {"sphere": [4, 4, 4], "capsule": [5, 5, 1], "box": [3, 4, 5]}
    for name, shape in zip(NAMES, SHAPES, strict=True):
        if name in expected:
            np.testing.assert_allclose(shape.at(points).value, expected[name], atol=1e-12)
    corner = SHAPES[-1].at(np.array([[4.0, 3.0, 2.0]]))
    np.testing.assert_allclose(corner.value, 0.5 * np.sqrt(3) - 0.5, rtol=1e-12)
