"""Force closure, against what is known of two and three contacts."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.mechanics.contact.force_closure import margin


def patches(angles_deg: list[float], spread_mm: float = 3.0) -> tuple[np.ndarray, np.ndarray]:
    """Square patches of four points each on a cylinder of 10 mm, pushing inwards."""
    points, normals = [], []
    for angle in np.radians(angles_deg):
        outward = np.array([np.cos(angle), np.sin(angle), 0])
        along = np.array([-np.sin(angle), np.cos(angle), 0])
        for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            points.append(10 * outward + spread_mm / 2 * (a * along + b * np.array([0, 0, 1])))
            normals.append(-outward)
    return np.array(points), np.array(normals)


def found(angles_deg: list[float], friction: float) -> float:
    points, normals = patches(angles_deg)
    return margin(points, normals, np.ones(len(points)), friction)


def test_opposite_patches_close_with_friction_alone() -> None:
    """Nguyen, Constructing Force-Closure Grasps, Int. J. Robotics Research 7, 1988."""
    assert 0.01 < found([0, 180], 0.4) <= 0.4
    assert found([0, 180], 0.0) == pytest.approx(0, abs=1e-9)
    assert found([0, 180], 0.2) < found([0, 180], 0.6)


def test_one_side_never_closes() -> None:
    assert found([0], 0.5) == pytest.approx(0, abs=1e-9)
    assert found([-20, 20], 0.3) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("angle", "closes"), [(90, False), (150, True)])
def test_two_patches_close_where_each_lies_in_the_others_cone(angle: float, closes: bool) -> None:
    """The line between them makes 90° − angle/2 with either normal; here μ = tan 21.8°."""
    points, normals = patches([0, angle], spread_mm=0.2)
    assert (margin(points, normals, np.ones(len(points)), 0.4) > 1e-6) == closes


def test_three_patches_around() -> None:
    assert found([0, 120, 240], 0.3) > 0.01
    points, normals = patches([0, 180])
    assert margin(points[:1], normals[:1], np.ones(1), 0.4) == 0.0
