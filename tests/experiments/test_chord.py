"""The chord's angle between edges and points, as a camera sees it."""

from __future__ import annotations

import numpy as np
import pytest
from support import small

from dolfingrip.config import ConfigError
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.observation import Observation, chord
from dolfingrip.mechanics.readings.chord import back_edge

LENGTH = 38.0


def finger(*overrides: str) -> FingerModel:
    return small.model(small.short(*overrides), plate=False)


def displaced(found: FingerModel) -> np.ndarray:
    """Bent by hand: u_x = −a z², u_z = −b z² + c x; returns the nodes."""
    nodes = found.model.u.function_space.tabulate_dof_coordinates()
    x, _, z = nodes.T
    u = np.stack([-4e-3 * z**2, 0 * z, -1e-3 * z**2 + 0.1 * x], axis=1)
    found.model.u.x.array[:] = u.ravel()
    return nodes


def test_back_edges() -> None:
    """atan(−u_x/(L + u_z)) of the back's edge at the tip; the faces' centres see another."""
    found = finger("camera.chord=back edges")
    observation = Observation(found)
    displaced(found)
    angle = observation.read()["chord_angle_deg"]
    expected = np.degrees(np.arctan(4e-3 * LENGTH**2 / (LENGTH - 1e-3 * LENGTH**2)))
    assert angle == pytest.approx(expected, rel=1e-9)
    other = finger()
    centres = Observation(other)
    displaced(other)
    assert abs(centres.read()["chord_angle_deg"] - expected) > 0.1


def test_an_edges_mean_is_that_of_a_linear_function() -> None:
    found = finger()
    weights = back_edge(found.model, "tip")
    y = found.model.u.function_space.tabulate_dof_coordinates()[:, 1]
    on = y[weights > 0]
    assert len(on) > 2
    assert weights.sum() == pytest.approx(1.0, rel=1e-14)
    assert weights @ y == pytest.approx((on.min() + on.max()) / 2, rel=1e-12)


def test_points() -> None:
    found = finger("camera.chord=points", "camera.from_mm=[16, 0, 0]", "camera.to_mm=[16, 10, 38]")
    angle = Observation(found)
    displaced(found)
    arm = LENGTH - 1e-3 * LENGTH**2  # both ends move by 0.1 x
    expected = np.degrees(np.arctan(4e-3 * LENGTH**2 / arm))
    assert angle.read()["chord_angle_deg"] == pytest.approx(expected, rel=1e-9)


def test_a_cup_hides_the_edge_at_the_end_face() -> None:
    """The chord begins where the block leaves the cup."""
    found = finger(
        "finger.kind=cast", "finger.length_mm=90", "finger.bellows=8", "cast.chambers=1",
        "cast.cup_mm=5", "camera.chord=back edges",
    )  # fmt: skip
    reading = chord(found)
    displaced(found)
    x, z = 4e-3 * (21.0**2 - 25.0), 16.0 - 1e-3 * (21.0**2 - 25.0)
    assert reading.value() == pytest.approx(np.degrees(np.arctan(x / z)), rel=1e-9)


def test_derivative() -> None:
    """By the displacement, against central differences."""
    found = finger("camera.chord=back edges")
    reading, u = chord(found), found.model.u.x.array
    displaced(found)
    way = np.random.default_rng(5).uniform(-1, 1, u.size)
    here, step = u.copy(), 1e-5
    ends = []
    for sign in (1, -1):
        u[:] = here + sign * step * way
        ends.append(reading.value())
    u[:] = here
    expected = (ends[0] - ends[1]) / (2 * step)
    assert reading.gradient() @ way == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (["camera.chord=points"], "camera.from_mm = none: allowed with chord"),
        (["camera.from_mm=[0, 0, 0]"], "camera.from_mm = [0.0, 0.0, 0.0]: allowed: with chord"),
        (["camera.chord=edge"], 'camera.chord = "edge": allowed: centres, back edges, points'),
        (
            ["camera.chord=points", "camera.from_mm=[0, 0, 0]", "camera.to_mm=[0, 0, 99]"],
            "camera.to_mm = [0.0, 0.0, 99.0]: allowed: a point of the finger",
        ),
    ],
)
def test_bad_cameras_are_one_clear_line(overrides: list[str], said: str) -> None:
    with pytest.raises(ConfigError) as error:
        Observation(finger(*overrides))
    assert str(error.value).startswith(said)
