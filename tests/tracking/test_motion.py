"""Noise of single frames is taken out of a motion that stops and turns, and told as it is."""

from __future__ import annotations

import numpy as np
import pytest
from support.filmed import Filmed, arc

from dolfingrip.tracking import motion, plane
from dolfingrip.tracking.points import TrackedPoints
from dolfingrip.tracking.sheet import SHEETS

SEED = 7301
NOISE_PX = 0.2


def noisy(lost: bool) -> tuple[TrackedPoints, np.ndarray]:
    """An arc that rests, bends, stops and turns back within 70 frames, and where it truly is."""
    print(f"seed {SEED}")
    rng = np.random.default_rng(SEED)
    bends = np.interp(np.arange(70), [8, 30, 36, 64], [0.0, 70.0, 70.0, 0.0])
    true = np.array([3.0 * arc(bend) for bend in bends])
    px, seen = true + rng.normal(0, NOISE_PX, true.shape), np.ones(true.shape[:2])
    if lost:
        px[28:35, -1], seen[28:35, -1] = np.nan, 0.0
        px[36:42, -1] += 0.8
        seen[36:42, -1] = 0.6
    names = [str(i) for i in range(len(true))]
    return TrackedPoints(names, np.arange(70) / 30, px, seen, radius_px=5.0), true


def turns(px: np.ndarray) -> np.ndarray:
    """Turn (deg) of the line between the last two points."""
    arm = px[:, -1] - px[:, -2]
    return np.degrees(np.arctan2(arm[:, 0], arm[:, 1]))


@pytest.mark.parametrize("lost", [False, True])
def test_noise_is_taken_out_and_the_errors_that_are_told_hold_the_truth(lost: bool) -> None:
    points, true = noisy(lost)
    found = motion.follow(points)
    assert found.frame_px[:-1] == pytest.approx(NOISE_PX, rel=0.35)
    off = found.px - true
    np.testing.assert_array_equal(np.isnan(off), np.isnan(points.px))
    before, after = (np.nanstd(turns(px) - turns(true)) for px in (points.px, found.px))
    assert after < 0.5 * before
    assert abs(np.nanmean(off[28:38, :-1])) < 0.1  # no stop is rounded off
    rng = np.random.default_rng(SEED)
    draws = [turns(found.jittered(rng)) - turns(found.px) for _ in range(40)]
    ratio = (turns(found.px) - turns(true)) / np.std(draws, axis=0)
    assert 0.7 < np.nanmean(np.abs(ratio) < 1.645) <= 1.0
    assert np.nanstd(ratio) > 0.4


def test_pictures_without_time_stay_as_they_are() -> None:
    points, _ = noisy(lost=False)
    points.time_s[:] = np.nan
    found = motion.follow(points)
    np.testing.assert_array_equal(found.px, points.px)
    np.testing.assert_allclose(found.std_px, motion.ORDINARY_PX)


def test_a_focal_length_that_is_not_known_moves_no_place_beside_the_sheet() -> None:
    """Cameras that fit a sheet see its corners where they are, whatever their focal lengths."""
    camera = Filmed(tilt_deg=1.0)
    mm, px = SHEETS["a4"].find(camera.frame(arc(40.0)))
    found = plane.of_sheet(camera.size_px, mm, px, (0.0, 1e-3))
    assert not found.determined(plane.F)
    draws = found.draws(50, np.random.default_rng(SEED))
    draws[:, 12:] = 0.0
    off = np.array([found.plane_mm(px, draw) - mm for draw in draws])
    assert np.sqrt((off**2).mean()) < 0.15
