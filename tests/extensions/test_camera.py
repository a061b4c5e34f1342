"""Errors of a camera: places and angles against a pinhole camera in space, and closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.pinhole import Pinhole

from dolfingrip import config
from dolfingrip.config import Config

RADIUS_mm = 70.0
MARKERS = np.array([[2.0, z] for z in np.linspace(5, 75, 15)])


def arc(rest_mm: np.ndarray) -> np.ndarray:
    """Places of points of a beam that is bent to a circle towards −x."""
    turn = rest_mm[:, 1] / RADIUS_mm
    x = rest_mm[:, 0] * np.cos(turn) - RADIUS_mm * (1 - np.cos(turn))
    return np.stack([x, (RADIUS_mm + rest_mm[:, 0]) * np.sin(turn)], axis=1)


def seen(places: np.ndarray, error: dict[str, Any], camera: dict[str, Any],
         angle_deg: float = 0.0) -> tuple[np.ndarray, dict[str, np.ndarray]]:  # fmt: skip
    """What a camera with an error shows of markers at rest and at places: (n, 2), and columns."""
    base = Config()
    markers = np.asarray(camera["markers"])
    true = {"time_s": np.array([0.0, 1.0]), "angle_deg": np.array([0.0, angle_deg])}
    for i, (rest, now) in enumerate(zip(markers, places, strict=True), 1):
        true |= {f"marker_{i}_{a}_mm": np.array([rest[k], now[k]]) for k, a in enumerate("xz")}
    made = config.changed(base, {f"extensions.{k}": v for k, v in error.items()})
    made = made.changed(camera={**camera, "markers": markers.tolist()})
    shown = made.extensions.displayed(true, made.camera)
    now = [[shown[f"marker_{i}_{a}_mm"][-1] for a in "xz"] for i in range(1, len(markers) + 1)]
    return np.array(now), shown


@pytest.mark.parametrize("turns", [(8.0, 0.0), (0.0, -7.0), (-9.0, 5.0)])
@pytest.mark.parametrize("ruler", [None, ((-40.0, 20.0), (10.0, 25.0))])
def test_a_tilted_camera(turns: tuple[float, float], ruler: Any) -> None:
    """Places to 0.02 mm, a tenth of what it changes, and angles of lines to 0.01°."""
    pinhole = Pinhole(*turns, 400.0, (-15.0, 35.0))
    told = None if ruler is None else np.array(ruler)
    line = MARKERS[[0, -1]]
    at_rest = pinhole.read(MARKERS, line, told)
    expected = pinhole.read(arc(MARKERS), line, told)
    camera = {"markers": at_rest, "distance_mm": 400.0, "centre_mm": (-15.0, 35.0)}
    camera |= {"scale_mm": ruler} if ruler else {}
    error = {"camera_tilt": dict(zip(("about_z_deg", "about_x_deg"), turns, strict=True))}
    turn = np.degrees(MARKERS[-1, 1] / RADIUS_mm)
    # the simulation follows the points that the camera showed at rest
    found, columns = seen(arc(at_rest), error, camera, turn)
    assert np.abs(expected - arc(at_rest)).max() > 0.2
    np.testing.assert_allclose(found, expected, atol=0.02)
    tip = arc(MARKERS)[-1]
    face = tip + np.array([[0, 0], [-np.sin(np.radians(turn)), np.cos(np.radians(turn))]])
    now, before = (pinhole.read(p, line, told) for p in (face, MARKERS[-1] + [[0, 0], [0, 1]]))
    angles = [np.degrees(np.arctan2(-d[0], d[1])) for d in (now[1] - now[0], before[1] - before[0])]
    assert columns["angle_deg"][-1] == pytest.approx(angles[0] - angles[1], abs=0.01)
    assert columns["angle_deg"][0] == pytest.approx(0.0, abs=1e-9)


def test_a_far_camera_bends_45_degrees_by_a_third() -> None:
    """Tan α′ = cos θ tan α: a turn of 8° alone bends 45° by 0.28°."""
    made = config.changed(Config(), {"extensions.camera_tilt": {"about_z_deg": 8.0}})
    true = {"time_s": np.zeros(1), "angle_deg": np.array([45.0])}
    expected = np.degrees(np.arctan(np.cos(np.radians(8.0))))
    assert made.extensions.displayed(true)["angle_deg"] == pytest.approx(expected, abs=1e-9)
    assert expected == pytest.approx(44.72, abs=0.01)


@pytest.mark.parametrize(
    ("error", "gain", "offset"),
    [
        ({"camera_scale": {"gain": 1.03}}, 1.03, (0.0, 0.0)),
        ({"camera_zero": {"x_mm": 0.4, "z_mm": -1.2, "angle_deg": 0.0}}, 1.0, (0.4, -1.2)),
    ],
)
def test_points_that_seem_elsewhere(
    error: dict[str, Any], gain: float, offset: tuple[float, float]
) -> None:
    """Both are a map of places, and followed are the points that it showed at rest."""
    at_rest = gain * MARKERS + offset
    found, columns = seen(arc(at_rest), error, {"markers": at_rest})
    expected = gain * arc(MARKERS) + offset
    assert np.abs(expected - arc(at_rest)).max() > 0.3
    np.testing.assert_allclose(found, expected, atol=0.01)
    first = [[columns[f"marker_{i}_{a}_mm"][0] for a in "xz"] for i in range(1, 16)]
    np.testing.assert_allclose(first, at_rest, atol=1e-9)
    assert columns["angle_deg"][-1] == pytest.approx(0.0, abs=1e-9)


def test_markers_at_equal_distances_are_where_they_are() -> None:
    """No picture told their places: the scale is a factor of them."""
    made = config.changed(Config(), {"extensions.camera_scale": {"gain": 1.02}})
    made = made.changed(camera={"markers": 3})
    true = {"time_s": np.zeros(1), "curvature_2_per_m": np.array([9.0])}
    places = {1: (-1.0, 20.0), 2: (-4.0, 39.0), 3: (-9.0, 57.0)}
    true |= {f"marker_{i}_{a}_mm": np.array([p[k]])
             for i, p in places.items() for k, a in enumerate("xz")}  # fmt: skip
    shown = made.extensions.displayed(true, made.camera)
    assert shown["marker_3_x_mm"] == pytest.approx(-9.18)
    # turns of the polygon by the mean length of its steps, both measured on paper
    turn = np.arctan2(5, 18) - np.arctan2(3, 19)
    mean = (np.hypot(3, 19) + np.hypot(5, 18)) / 2 * 1.02e-3
    assert shown["curvature_2_per_m"] == pytest.approx(turn / mean, rel=1e-9)


def test_a_zero_of_the_angle_and_a_force_that_stays() -> None:
    made = config.changed(Config(), {"extensions.camera_zero": {"angle_deg": 1.5}})
    true = {"time_s": np.zeros(2), "angle_deg": np.array([0.0, 30.0]), "force_N": np.ones(2)}
    shown = made.extensions.displayed(true)
    np.testing.assert_allclose(shown["angle_deg"], [1.5, 31.5], rtol=1e-12)
    assert shown["force_N"] is true["force_N"]


@pytest.mark.parametrize("late_s", [0.4, -0.4])
def test_a_clock_that_is_late_or_early(late_s: float) -> None:
    """On a ramp of 4°/s it shows 1.6° less or more, and in a wait what stands still."""
    made = config.changed(Config(), {"extensions.camera_clock": {"late_s": late_s}})
    time_s = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    angle = 4 * np.minimum(time_s, 2.0)
    true = {"time_s": time_s, "angle_deg": angle, "marker_1_x_mm": -angle, "force_N": angle}
    shown = made.extensions.displayed(true)
    expected = 4 * np.clip(time_s - late_s, 0.0, 2.0)
    np.testing.assert_allclose(shown["angle_deg"], expected, atol=1e-9)
    np.testing.assert_allclose(shown["marker_1_x_mm"], -expected, atol=1e-9)
    np.testing.assert_array_equal(shown["force_N"], angle)
