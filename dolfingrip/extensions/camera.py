"""The base class of a camera's errors: each changes all places and angles that a picture shows.

Places are x and z (mm) from the clamp, as a table has them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import ClassVar, Final

import numpy as np
from scipy.interpolate import CubicSpline

from dolfingrip.channels import ANGLE, CHORD_ANGLE, TIP_X, TIP_Z, at_marker, curvature, marker
from dolfingrip.extensions.effect import Effect
from dolfingrip.sections.fixture import Camera

SHEET: Final = "the printed sheet of `dolfingrip track` behind the finger"
"""Measurement that tells several numbers of a camera."""

TURNS: Final = 8
"""Steps of the fixed point that finds which place is shown somewhere; each gains two digits."""


def in_picture(names: Iterable[str]) -> list[str]:
    """List the columns of angles and places that a picture shows, among some names.

    Args:
        names: of columns.
    """
    shown = {ANGLE.name, CHORD_ANGLE.name, TIP_X.name, TIP_Z.name}
    return [name for name in names if name in shown or at_marker(name)]


class CameraError(Effect):
    """An error of a camera, which changes what it shows of places.

    Places of markers in the set-up are where the camera showed them at rest. So an error moves the
    points of the body that are followed, too.
    """

    kind: ClassVar = "measurement"
    felt_by: ClassVar = ("finger",)

    def shown_mm(self, places_mm: np.ndarray, camera: Camera) -> np.ndarray:
        """Return where places (…, 2) are shown; straight lines stay straight.

        Args:
            places_mm: x and z from the clamp.
            camera: set-up of the camera.
        """
        raise NotImplementedError

    def reading(self, true: Mapping[str, np.ndarray], camera: Camera) -> Mapping[str, np.ndarray]:
        """Show places and angles; that of the tip's face as a line at the last marker.

        Args:
            true: see :class:`~dolfingrip.extensions.effect.Displaying`.
            camera: set-up of the camera.
        """
        count = camera.markers if isinstance(camera.markers, int) else len(camera.markers)
        numbers = [
            i for i in range(1, count + 1) if {marker(i, axis).name for axis in "xz"} <= true.keys()
        ]
        shown: dict[str, np.ndarray] = {}
        centre = np.array(camera.centre_mm or (0.0, 0.0))
        tip = resting = centre
        if numbers:
            now, at_rest = self._followed(numbers, true, camera)
            tip, resting = now[:, -1], at_rest[-1]
            seen = self.shown_mm(now, camera)
            for place, i in enumerate(numbers):
                shown |= {marker(i, axis).name: seen[:, place, k] for k, axis in enumerate("xz")}
                if 0 < place < len(numbers) - 1 and curvature(i).name in true:
                    shown[curvature(i).name] = turns_per_m(seen[:, place - 1 : place + 2])
        if ANGLE.name in true:
            shown[ANGLE.name] = self._angle(tip, resting, true[ANGLE.name], camera)
        if CHORD_ANGLE.name in true:
            clamp = np.zeros(2)
            shown[CHORD_ANGLE.name] = self._angle(clamp, clamp, true[CHORD_ANGLE.name], camera)
        names = TIP_X.name, TIP_Z.name
        if {*names} <= true.keys():
            moved = resting + np.stack([true[name] for name in names], axis=1)
            seen = self.shown_mm(moved, camera) - self.shown_mm(resting, camera)
            shown |= {name: seen[:, k] for k, name in enumerate(names)}
        return shown

    def _followed(
        self, numbers: Sequence[int], true: Mapping[str, np.ndarray], camera: Camera
    ) -> tuple[np.ndarray, np.ndarray]:
        """Places (rows, n, 2) of the points that are followed, and those at rest (n, 2)."""
        now = np.stack(
            [np.stack([true[marker(i, axis).name] for axis in "xz"], axis=1) for i in numbers],
            axis=1,
        )
        if isinstance(camera.markers, int):
            return now, now[0]
        seen_at_rest = np.array(camera.markers)[np.array(numbers) - 1]
        resting = seen_at_rest.copy()
        for _ in range(TURNS):
            resting += seen_at_rest - self.shown_mm(resting, camera)
        if len(numbers) < 2:
            return now, resting
        solved = np.isfinite(now).all(axis=(1, 2))
        now[solved] = carried(now[solved], seen_at_rest, resting - seen_at_rest)
        return now, resting

    def _angle(
        self, at: np.ndarray, resting: np.ndarray, angle_deg: np.ndarray, camera: Camera
    ) -> np.ndarray:
        """Angle (rows,) that a line through places is shown to have turned by since rest."""
        angle = np.radians(angle_deg)
        line = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        now = self.shown_mm(at + line, camera) - self.shown_mm(at, camera)
        before = self.shown_mm(resting + np.array([0.0, 1.0]), camera) - self.shown_mm(
            resting, camera
        )
        turned = np.degrees(np.arctan2(-now[:, 0], now[:, 1]) - np.arctan2(-before[0], before[1]))
        return np.asarray(turned + 360 * np.round((angle_deg - turned) / 360))


def carried(now_mm: np.ndarray, at_rest_mm: np.ndarray, off_mm: np.ndarray) -> np.ndarray:
    """Return places (rows, n, 2) of points of a body near markers of it.

    Such a point moves with the line through all markers, and stays square to it.

    Args:
        now_mm: (rows, n, 2) places of the markers, at least two.
        at_rest_mm: (n, 2) those at rest.
        off_mm: (n, 2) from each marker at rest to the point.
    """
    steps = np.linalg.norm(np.diff(at_rest_mm, axis=0), axis=1)
    way = np.r_[0.0, np.cumsum(steps)]
    before = CubicSpline(way, at_rest_mm)(way, 1)
    before /= np.linalg.norm(before, axis=1)[:, None]
    line = CubicSpline(way, now_mm, axis=1)
    there = way + (off_mm * before).sum(axis=1)
    by_across = (off_mm * _across(before)).sum(axis=1)
    return np.asarray(line(there) + by_across[:, None] * _across(line(there, 1)))


def _across(along: np.ndarray) -> np.ndarray:
    """Unit vectors square to others (…, 2), at rest along x."""
    square = np.stack([along[..., 1], -along[..., 0]], axis=-1)
    return square / np.linalg.norm(square, axis=-1, keepdims=True)


def turns_per_m(places_mm: np.ndarray) -> np.ndarray:
    """Return the curvature (rows,) at the second of three places, positive towards −x (1/m).

    It is the line's turn there by the mean length of both steps.

    Args:
        places_mm: x and z, (rows, 3, 2).
    """
    before, after = np.moveaxis(np.diff(places_mm, axis=1), 1, 0)
    turn = np.arctan2(
        before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1)
    )
    lengths = np.linalg.norm(before, axis=1) + np.linalg.norm(after, axis=1)
    return np.asarray(2e3 * turn / lengths)
