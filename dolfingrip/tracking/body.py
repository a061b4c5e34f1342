"""Body coordinates: places from the clamp, angles by their definitions, and their errors.

z goes along the finger at rest from the clamp to the tip, −x is the side to which it bends. The
angles count from rest and are positive towards −x, as those of the format of measured data.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.channels import ANGLE, CHORD_ANGLE, curvature, marker
from dolfingrip.extensions.camera import turns_per_m
from dolfingrip.tracking import motion
from dolfingrip.tracking.plane import Calibration
from dolfingrip.tracking.points import TrackedPoints

Floats = np.ndarray

DRAWS: Final = 60
STRAIGHT: Final = 0.04
"""Points at rest lie on a line along z where none is farther from it, by their distance."""
SEED: Final = 73
COLOUR_PX: Final = 0.5 / np.sqrt(12)
"""Standard deviation of the place of colour along a line of pixels: a video has it at the left one
of two pixels or between them, and few tell at which."""


@dataclass(frozen=True)
class Frameless:
    """Where a finger is in the plane of bending.

    Attributes:
        axes: (2, 2) unit vectors of x and z in the plane.
        origin_mm: (2,) where the clamp holds the back; NaN where nothing tells it.
    """

    axes: Floats
    origin_mm: Floats

    def of(self, plane_mm: Floats) -> Floats:
        """x and z (…, 2) of places in the plane (…, 2).

        Args:
            plane_mm: u and v.
        """
        origin = np.nan_to_num(self.origin_mm)
        return np.asarray((plane_mm - origin) @ self.axes.T)


@dataclass(frozen=True)
class Body:
    """Readings of one finger.

    Attributes:
        readings: (frames,) by column.
        noise: (frames,) standard deviations of what changes from frame to frame, by column.
        single: those that it would have in frames which know nothing of each other, by column.
        common: (frames,) standard deviations of what all frames have in common, by column.
        draws: readings by other cameras that fit what was seen, of the same tilt where nothing
            tells it.
        frame_px: standard deviation of a point in a single frame.
        rest_mm: (points, 2) x and z at rest.
        on_back: whether the points are those that divide the middle of the back equally.
        frame: where the finger is in the plane of bending.
        from_clamp: whether places count from the clamp.
        bends: the side of the picture to which it bends.
        askew_deg: angle between the finger at rest and the sheet's edge; NaN without a sheet.
        compared: columns that a simulation has by the same definition. With dots these are their
            places, as the line between two of them turns less than the tip's face where the finger
            bends between them; its angle is compared where no place counts from the clamp.
        defined: what each angle is, by column.
    """

    readings: dict[str, Floats]
    noise: dict[str, Floats]
    single: dict[str, Floats]
    common: dict[str, Floats]
    draws: list[dict[str, Floats]]
    frame_px: float
    rest_mm: Floats
    on_back: bool
    frame: Frameless
    from_clamp: bool
    bends: str
    askew_deg: float
    compared: list[str]
    defined: dict[str, str]


def resting(px: Floats, noise_px: Floats) -> Floats:
    """Numbers of the first frames, in which no point has moved.

    Args:
        px: (frames, points, 2).
        noise_px: (points,) in a single frame.
    """
    moved = np.abs(px - px[0]).max(axis=2) > 4 * noise_px
    moves = np.flatnonzero(moved.any(axis=1))
    return np.arange(max(int(moves[0]) if len(moves) else len(px), 1))[:60]


def clamp_end_first(px: Floats) -> bool:
    """Say whether the first point of a chain moves less than the last one.

    Args:
        px: (frames, points, 2) along the body.
    """
    spans = [float(np.nanmax(np.linalg.norm(px[:, i] - px[0, i], axis=1))) for i in (0, -1)]
    return spans[0] <= spans[1]


def read(
    points: TrackedPoints, camera: Calibration, origin_px: Floats | None, side: str | None
) -> Body:
    """Read a finger.

    Args:
        points: from the clamp to the tip.
        camera: from pixels to the plane.
        origin_px: where the clamp holds the back; None: the sheet's mark, if there is a sheet.
        side: to which it bends in the picture, ``left`` or ``right`` of the way from clamp to
            tip as seen; None: by its motion.
    """
    moving, count = motion.follow(points), points.px.shape[1]
    at_rest = resting(points.px, moving.frame_px[:count])
    generator = np.random.default_rng(SEED)
    plane = camera.plane_mm(moving.px[:, :count])
    frame, bends, askew = _placed(plane, at_rest, camera, origin_px, side)

    def values(marks_px: Floats, unknowns: Floats | None) -> dict[str, Floats]:
        marks_mm = camera.plane_mm(marks_px, unknowns)
        places_mm, corners_mm = marks_mm[:, :count], marks_mm[:, count:]
        turned, _, _ = _placed(places_mm, at_rest, camera, origin_px, bends, unknowns)
        tags = turned.of(corners_mm.reshape(len(marks_mm), -1, 4, 2)) if corners_mm.size else None
        return _readings(turned.of(places_mm), tags, at_rest, np.isfinite(turned.origin_mm).all())

    def drawn(of: Calibration) -> list[dict[str, Floats]]:
        draws = of.draws(DRAWS, generator)
        shared = np.zeros((DRAWS, 1, 1, 2)) if points.shared_px is None else points.shared_px
        if points.radius_px:
            shared[..., 0] = generator.normal(0.0, COLOUR_PX, (DRAWS, 1, 1))
        return [values(moving.px + off, draw) for off, draw in zip(shared, draws, strict=True)]

    readings = values(moving.px, None)
    draws = drawn(camera.square)
    common = _spread(readings, draws if camera.has_sheet else drawn(camera))
    noise, single = (
        _spread(readings, [values(of.jittered(generator), None) for _ in range(DRAWS)])
        for of in (moving, moving.single)
    )
    tip = (
        "the last tag" if points.corners_px is not None else "the line between the last two points"
    )
    defined = {
        ANGLE.name: f"rotation of {tip}",
        CHORD_ANGLE.name: "rotation of the line from the first point to the last one",
    }
    from_clamp = bool(np.isfinite(frame.origin_mm).all())
    compared = [name for name in readings if name.startswith("marker_")]
    if points.corners_px is not None or not from_clamp:
        compared.insert(0, ANGLE.name)
    return Body(
        readings, noise, single, common, draws, float(moving.frame_px[:count].mean()),
        np.nanmedian(frame.of(plane[at_rest]), axis=0), points.shared_px is not None, frame,
        from_clamp, bends, askew, compared, defined,
    )  # fmt: skip


def _placed(
    plane: Floats, at_rest: Floats, camera: Calibration, origin_px: Floats | None, side: str | None,
    unknowns: Floats | None = None,
) -> tuple[Frameless, str, float]:  # fmt: skip
    """Axes and origin of a finger, the side to which it bends, and its angle to the sheet."""
    places = np.nanmedian(plane[at_rest], axis=0)
    middle = places.mean(axis=0)
    along = np.linalg.svd(places - middle)[2][0]
    along *= np.sign(along @ (places[-1] - places[0])) or 1.0
    off = (places - middle) @ np.array([-along[1], along[0]])
    straight = np.abs(off).max() < STRAIGHT * np.linalg.norm(places[-1] - places[0])
    askew = float("nan")
    if camera.has_sheet:
        askew = float(np.degrees(np.arctan2(along[0], along[1])))
        if not straight:
            along = np.array([0.0, 1.0])
    elif not straight:
        along = (places[-1] - places[0]) / np.linalg.norm(places[-1] - places[0])
    across = np.array([-along[1], along[0]])
    if side is None:
        moves = (plane[:, -1] - places[-1]) @ across
        # across is to the left of the way from clamp to tip as it is seen, downwards: to the left
        side = "left" if moves[np.nanargmax(np.abs(moves))] > 0 else "right"
    x = across if side == "right" else -across
    origin = np.full(2, np.nan)
    if origin_px is not None:
        origin = camera.plane_mm(np.asarray(origin_px, dtype=float)[None], unknowns)[0]
    elif camera.has_sheet:
        origin = np.zeros(2)
    return Frameless(np.array([x, along]), origin), side, askew


def _readings(
    places: Floats, tags: Floats | None, at_rest: Floats, from_clamp: bool
) -> dict[str, Floats]:
    """Columns from places (frames, points, 2) and corners (frames, points, 4, 2)."""
    readings: dict[str, Floats] = {}
    if tags is not None:
        readings[ANGLE.name] = _turn(tags[:, -1], np.nanmedian(tags[at_rest, -1], axis=0))
    else:
        readings[ANGLE.name] = _line(places[:, -2], places[:, -1], at_rest)
    readings[CHORD_ANGLE.name] = _line(places[:, 0], places[:, -1], at_rest)
    count = places.shape[1]
    if from_clamp:
        for i in range(count):
            readings[marker(i + 1, "x").name] = places[:, i, 0]
            readings[marker(i + 1, "z").name] = places[:, i, 1]
    for i in range(1, count - 1):
        readings[curvature(i + 1).name] = turns_per_m(places[:, i - 1 : i + 2])
    return readings


def _line(start: Floats, end: Floats, at_rest: Floats) -> Floats:
    """Rotation of a line from rest (deg), positive towards −x; NaN where an end is lost."""
    arm = end - start
    return _from_rest(np.arctan2(-arm[:, 0], arm[:, 1]), at_rest)


def _turn(corners: Floats, at_rest: Floats) -> Floats:
    """Rotation of a tag (deg) from its corners at rest, positive towards −x."""
    now = corners - corners.mean(axis=1, keepdims=True)
    before = at_rest - at_rest.mean(axis=0)
    along = (now * before).sum(axis=(1, 2))
    across = (before[:, 0] * now[..., 1] - before[:, 1] * now[..., 0]).sum(axis=1)
    return _from_rest(np.arctan2(across, along), None)


def _from_rest(angle: Floats, at_rest: Floats | None) -> Floats:
    there = np.isfinite(angle)
    unwrapped = np.full(len(angle), np.nan)
    unwrapped[there] = np.unwrap(angle[there])
    zero = 0.0 if at_rest is None else np.nanmedian(unwrapped[at_rest])
    return np.asarray(np.degrees(unwrapped - zero))


def _spread(mean: dict[str, Floats], draws: list[dict[str, Floats]]) -> dict[str, Floats]:
    """Root mean square of the differences from the mean, by column."""
    return {
        name: np.sqrt(np.mean([(draw[name] - value) ** 2 for draw in draws], axis=0))
        for name, value in mean.items()
    }
