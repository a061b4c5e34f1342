"""Readings against motions and volumes that are known by hand."""

from __future__ import annotations

import numpy as np
import pytest
from support import small

from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.meshes.quality import check


@pytest.fixture(scope="module", params=["true", "false"], ids=["half", "whole"])
def finger(request: pytest.FixtureRequest) -> FingerModel:
    return small.model(small.short(f"mesh.half={request.param}"), plate=False)


def _turn(finger: FingerModel, degrees: float) -> np.ndarray:
    """Rotate the finger rigidly about y through the clamp's centre, towards −x if positive."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    pivot = np.array([finger.config.finger.depth_mm / 2, 0, 0])[:, None]
    finger.model.u.interpolate(lambda x: (turn - np.eye(3)) @ (x - pivot))
    return turn


def test_rigid_rotation_is_read_beyond_half_a_turn(finger: FingerModel) -> None:
    """The face turns with the body and so does the chord: both read the angle itself."""
    observation = Observation(finger)
    rest = observation.read()
    for degrees in (0.0, 10.0, 170.0, 200.0, 359.0, 365.0, 200.0, 30.0, -30.0):
        turn = _turn(finger, degrees)
        row = observation.read()
        assert row["angle_deg"] == pytest.approx(degrees, abs=1e-9)
        assert row["chord_angle_deg"] == pytest.approx(degrees, abs=1e-9)
        tip = np.array([0, 0, finger.config.finger.length_mm])
        moved = turn @ tip - tip
        assert row["tip_x_mm"] == pytest.approx(moved[0], abs=1e-9)
        assert row["tip_z_mm"] == pytest.approx(moved[2], abs=1e-9)
        assert row["cavity_volume_mm3"] == pytest.approx(rest["cavity_volume_mm3"], rel=1e-12)


def _curl(finger: FingerModel, degrees: float) -> None:
    """Bend the finger along a circular arc, whose back keeps its length, by an angle of its tip."""
    radius = finger.config.finger.length_mm / np.radians(degrees)

    def moved(x: np.ndarray) -> np.ndarray:
        turn, away = x[2] / radius, radius + x[0]
        return np.array([away * np.cos(turn) - radius, x[1], away * np.sin(turn)]) - x

    finger.model.u.interpolate(moved)


@pytest.mark.parametrize("degrees", [185.8, 226.9, 270.0, -270.0, 350.0])
def test_one_reading_tells_a_curl_beyond_half_a_turn(finger: FingerModel, degrees: float) -> None:
    """The first reading after rest, with no other between. An arc's chord turns by half of it."""
    observation = Observation(finger)
    observation.read()
    _curl(finger, degrees)
    row = observation.read()
    assert row["angle_deg"] == pytest.approx(degrees, abs=0.5)  # of the interpolated arc
    assert row["chord_angle_deg"] == pytest.approx(degrees / 2, abs=0.5)
    _curl(finger, 20.0)
    assert observation.read()["angle_deg"] == pytest.approx(20.0, abs=0.1)


def test_positive_angles_bend_towards_the_base_layer(finger: FingerModel) -> None:
    _turn(finger, 10.0)
    assert Observation(finger).read()["tip_x_mm"] < 0


def test_angles_count_from_the_tared_pose(finger: FingerModel) -> None:
    observation = Observation(finger)
    _turn(finger, 4.0)
    observation.tare()
    assert observation.read()["angle_deg"] == 0.0
    _turn(finger, 10.0)
    row = observation.read()
    assert row["angle_deg"] == pytest.approx(6.0, abs=1e-9)
    assert row["chord_angle_deg"] == pytest.approx(6.0, abs=1e-9)


def test_cavity_at_rest_is_that_of_the_mesh_and_of_the_drawing(finger: FingerModel) -> None:
    settings = finger.config.finger
    finger.model.u.x.array[:] = 0.0
    row = Observation(finger).read()
    mesh = check(solid(finger.config)).cavity_mm3 * finger.model.domain.copies
    assert row["cavity_volume_mm3"] == pytest.approx(mesh, rel=1e-12)
    inner = settings.bellows_mm - 2 * settings.wall_mm
    high = settings.depth_mm - settings.base_layer_mm - settings.wall_mm
    between = settings.pitch_mm - inner
    drawing = settings.chamber_width_mm * (
        settings.bellows * inner * high + (settings.bellows - 1) * between * settings.channel_mm
    )
    assert row["cavity_volume_mm3"] == pytest.approx(drawing, rel=1e-9)


def test_gaps_between_bellows_are_those_of_the_drawing(finger: FingerModel) -> None:
    finger.model.u.x.array[:] = 0.0
    observation = Observation(finger)
    observation.read()
    gaps = observation.gaps_mm
    assert gaps.keys() == {"bellows 1 and bellows 2", "bellows 2 and tip"}
    np.testing.assert_allclose(list(gaps.values()), finger.config.finger.gap_mm, rtol=1e-12)
