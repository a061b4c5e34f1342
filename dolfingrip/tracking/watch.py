"""One pass over the frames: points that are followed, corners of the sheet, a light."""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain
from typing import Any, Final

import numpy as np

from dolfingrip.tracking import body, dots, order, scale
from dolfingrip.tracking.asked import TrackAsked
from dolfingrip.tracking.follow import Follower
from dolfingrip.tracking.frames import FrameSource, Image
from dolfingrip.tracking.points import TrackedPoints, Watched
from dolfingrip.tracking.sheet import SHEETS, PrintedSheet
from dolfingrip.tracking.silhouette import Silhouette
from dolfingrip.tracking.tags import Tags

SHEET_EVERY_S: Final = 0.5
"""Time between frames in which the sheet is looked for."""
LIGHT_PX: Final = 3
"""Half the side of the part of a picture whose brightness is that of a light."""

BACK_POINTS: Final = 5
"""Number of points on the back of a finger without marks."""

Show = Callable[[int, int], None]
"""Gets the number of frames done, and of all."""


def watch(source: FrameSource, request: TrackAsked, show: Show) -> Watched:
    """Go through the frames once and follow the points.

    Args:
        source: of the frames.
        request: what is told.
        show: gets the number of frames done, and of all.

    Raises:
        ConfigError: one line with what was seen.
    """
    frames = iter(source)
    first = next(frames)
    sheet = max(SHEETS.values(), key=lambda printed: len(printed.find(first.image)[0]))
    follower, fingers = _begin(first.image, request, sheet)
    rows: list[Any] = []
    corners: list[tuple[np.ndarray, np.ndarray]] = []
    sought = -np.inf
    for frame in chain([first], frames):
        if not frame.time_s < sought + SHEET_EVERY_S:
            sighting = sheet.find(frame.image)
            corners += [sighting] if len(sighting[0]) else []
            sought = frame.time_s
        jumps = np.isnan(frame.time_s) and not isinstance(follower, Tags)
        step = follower.anew if jumps else follower.step
        light = _brightness(frame.image, request.light_px)
        rows.append((frame.name, frame.time_s, light, *step(frame.image)))
        show(len(rows), max(source.expected, len(rows)))
    names, *columns = zip(*rows, strict=True)
    times, lights, px, seen, *quads = map(np.array, columns)
    points = TrackedPoints(
        list(names), times, px, seen, quads[0] if quads else None, follower.radius_px
    )
    outlines: list[np.ndarray] = []
    if isinstance(follower, Silhouette):
        points, outlines = follower.completed(points), follower.outlines
    fingers = [way if body.clamp_end_first(points.px[:, way]) else way[::-1] for way in fingers]
    size_px = first.image.shape[1], first.image.shape[0]
    return Watched(points, fingers, corners, lights, size_px, outlines=outlines)


def _begin(image: Image, request: TrackAsked, sheet: PrintedSheet) -> tuple[Any, list[np.ndarray]]:
    """Begin to follow points; returns what does so, and the order along each finger."""
    if request.family is not None:
        nothing = TrackedPoints([], np.zeros(0), np.zeros((0, 0, 2)), np.zeros((0, 0)))
        sighting = sheet.find(image)
        size = image.shape[1], image.shape[0]
        corners = [sighting] if len(sighting[0]) else []
        seen = Watched(nothing, [], corners, np.zeros(0), size)
        camera = scale.calibrate(seen, request, request.family.width_mm / 2)
        count = request.count or BACK_POINTS
        back = Silhouette(request.family, camera, image, request.clamp_px, request.side, count)
        return back, [np.arange(count)]
    if request.tags is not None:
        tags = Tags(request.tags, image)
        return tags, order.fingers(tags.places, request.fingers)
    colour, places = dots.learn(
        image, request.colour, request.count, request.fingers, request.points_px
    )
    fingers = order.fingers(places, request.fingers)
    return Follower(colour, places, fingers), fingers


def _brightness(image: Image, at_px: np.ndarray | None) -> float:
    if at_px is None:
        return float("nan")
    u, v = np.round(at_px).astype(int)
    part = image[max(v - LIGHT_PX, 0) : v + LIGHT_PX + 1, max(u - LIGHT_PX, 0) : u + LIGHT_PX + 1]
    return float(part.mean()) if part.size else float("nan")


def doubtful(watched: Watched) -> dict[int, str]:
    """Frames in which something may be wrong, with the reason; those with the most lost first.

    Args:
        watched: what was seen.
    """
    points = watched.points
    lost = np.isnan(points.px[..., 0])
    partly = (points.seen > 0) & (points.seen < dots.POLICY.part_seen)
    number: dict[int, str] = {}
    for finger, members in enumerate(watched.fingers, 1):
        of_finger = f" of finger {finger}" if len(watched.fingers) > 1 else ""
        number |= {int(point): f"{place}{of_finger}" for place, point in enumerate(members, 1)}
    reasons = {}
    kinds = {"points lost": lost, "points partly hidden": partly}
    for i in np.argsort(-(10 * lost.sum(axis=1) + partly.sum(axis=1)), kind="stable"):
        words = [
            f"{what}: {', '.join(number[int(point)] for point in np.flatnonzero(which[i]))}"
            for what, which in kinds.items()
            if which[i].any()
        ]
        if not words:
            break
        reasons[int(i)] = "; ".join(words)
    return reasons
