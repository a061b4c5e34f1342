"""How the fingers of a gripper stand."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.meshes.gripper import stands
from dolfingrip.sections.errors import ConfigError, checked
from dolfingrip.sections.gripper import Gripper
from dolfingrip.sections.specimen import Finger

FINGER = Finger()
POSES = ("scoop", "pinch", "claw")


def ball(radius: float):  # type: ignore[no-untyped-def]
    return lambda way: radius


@pytest.mark.parametrize("pose", POSES)
def test_presets(pose: str) -> None:
    """All stand next to a ball, hang down and face it; B and C are mirror images."""
    gripper = Gripper(pose=pose)  # type: ignore[arg-type]
    found = stands(gripper, FINGER, ball(35.0))
    assert gripper.clearance == (42.0 if pose == "pinch" else 4.0)
    assert [stand.name for stand in found] == ["thumb A", "finger B", "finger C"]
    for stand in found:
        np.testing.assert_allclose(stand.rotation @ stand.rotation.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(stand.rotation) == pytest.approx(1)
        np.testing.assert_array_equal(stand.rotation[:, 2], [0, 0, -1])
        assert stand.origin_mm[2] == FINGER.length_mm + Gripper().tip_height_mm
        assert stand.origin_mm[:2] @ stand.outward == pytest.approx(35 + gripper.clearance)
    mirror = np.diag([1, -1, 1])
    np.testing.assert_allclose(mirror @ found[1].origin_mm, found[2].origin_mm, atol=1e-12)
    # a finger is itself symmetric in its y
    np.testing.assert_allclose(mirror @ found[1].rotation @ mirror, found[2].rotation, atol=1e-12)


def test_the_papers_angles() -> None:
    """Pinch: both at 180° from the thumb; claw: at 90°; scoop: closer to the thumb."""
    angles = {}
    for pose in POSES:
        a, b, _ = stands(Gripper(pose=pose), FINGER, ball(35.0))  # type: ignore[arg-type]
        angles[pose] = np.degrees(np.arccos(a.outward @ b.outward))
    assert angles["pinch"] == pytest.approx(180)
    assert angles["claw"] == pytest.approx(90)
    assert angles["scoop"] < 90
    a, b, c = stands(Gripper(pose="pinch", L_mm=30.0, W_mm=13.0, R_mm=25.0), FINGER)
    np.testing.assert_allclose(a.origin_mm[:2], [-30, 0])
    np.testing.assert_allclose(b.origin_mm[:2], [25, 13])
    np.testing.assert_allclose(c.origin_mm[:2], [25, -13])


@pytest.mark.parametrize(("given", "said"), [
    ({"pose": "pinch", "W_mm": 9.0, "L_mm": 30.0, "R_mm": 30.0}, "finger B and finger C intersect"),
    ({"alpha_deg": -80.0, "L_mm": 20.0, "R_mm": 20.0}, "thumb A and finger B intersect"),
])  # fmt: skip
def test_fingers_that_intersect_are_named(given: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError, match=rf"gripper: L_mm = .* R_mm = .*: {said}; allowed:"):
        stands(checked(Gripper, given), FINGER)


def test_a_turn_of_its_own_has_no_preset_distance() -> None:
    """The pinch's is set for its α alone; one that is given counts in any case."""
    assert Gripper(alpha_deg=30.0).clearance == 4.0
    assert Gripper(alpha_deg=30.0, clearance_mm=7.0).clearance == 7.0


def test_a_finger_in_the_foods_way() -> None:
    with pytest.raises(ConfigError, match=r"thumb A stands in the food's way by 5 mm; allowed:"):
        stands(Gripper(L_mm=30.0), FINGER, ball(35.0))
