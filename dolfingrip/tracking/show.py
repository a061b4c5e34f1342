"""The overlay of a video or of pictures, and pictures of doubtful frames."""

from __future__ import annotations

import re
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.channels import ANGLE, CHANNELS
from dolfingrip.files import video
from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking import overlay
from dolfingrip.tracking.frames import Frame, FrameSource
from dolfingrip.tracking.points import Unseen, Watched
from dolfingrip.tracking.track import Tracked
from dolfingrip.tracking.watch import Show, doubtful

DOUBTFUL: Final = 12
"""Pictures of doubtful frames at most."""
OVERLAY_HZ: Final = 15.0
"""Frames per second of the overlay, at most; those between are passed over."""


def show(source: FrameSource, tracked: Tracked, out: Path, progress: Show) -> None:
    """Write the overlay, and pictures of doubtful frames.

    Args:
        source: the frames, once more.
        tracked: what was found in them.
        out: folder.
        progress: gets the number of frames done, and of all.
    """
    watched = tracked.watched
    points, time_s = watched.points, watched.points.time_s
    doubts = dict(list(doubtful(watched).items())[:DOUBTFUL])
    moving = len(time_s) > 1 and np.isfinite(time_s).all()
    with ExitStack() as stack:
        if moving:
            rate = 1 / float(np.median(np.diff(time_s)))
            every = max(1, round(rate / OVERLAY_HZ))
            shown = video.growing(
                out / "overlay.mp4", Fraction(rate / every).limit_denominator(1000), "bgr24",
                {"preset": "veryfast", "crf": "26"},
            )  # fmt: skip
            add = stack.enter_context(shown)
        for frame in source:
            if frame.number >= len(points.names):
                break
            fingers = [points.px[frame.number, finger] for finger in watched.fingers]
            outline = watched.outlines[frame.number] if watched.outlines else None
            text = _caption(tracked, frame)
            if moving and frame.number % every == 0:
                scale = min(1.0, overlay.HEIGHT_PX / frame.image.shape[0])
                add(overlay.drawn(frame.image, fingers, text, outline, scale))
            if frame.number == 0 or not moving:
                stem = "first" if moving else re.sub(r"\W+", "_", Path(frame.name).stem)
                file = out / f"overlay_{stem}.png"
                overlay.picture(file, overlay.drawn(frame.image, fingers, text, outline))
            if frame.number in doubts:
                words = f"{text}; {doubts[frame.number]}"
                file = out / "doubtful" / f"{frame.number:06d}.png"
                overlay.picture(file, overlay.drawn(frame.image, fingers, words, outline))
            progress(frame.number + 1, len(points.names))


def refusal(
    error: ConfigError, source: FrameSource | None, watched: Watched | None, out: Path
) -> ConfigError:
    """Write the first frame with what was found in it, where frames are refused.

    Args:
        error: why they are.
        source: the frames; None: another program has tracked them.
        watched: what was seen in them; None: they were refused before.
        out: folder of the picture.

    Returns:
        The error, which names the picture where there is one.
    """
    try:
        first = None if source is None else next(iter(source))
    except ConfigError:
        first = None
    if source is None or first is None:
        return error
    points = [error.places_px] if isinstance(error, Unseen) else []
    if watched is not None:
        points += [watched.points.px[0, finger] for finger in watched.fingers]
        points += [px for _, px in watched.corners[:1]]
    file = out / "seen.png"
    overlay.picture(file, overlay.drawn(first.image, points, f"{source.name}: first frame"))
    return ConfigError(f"{error}; {file} shows the first frame")


def _caption(tracked: Tracked, frame: Frame) -> str:
    i = frame.number
    words = [frame.name if np.isnan(frame.time_s) else f"{frame.time_s:.2f} s"]
    angles = [(ANGLE.name, body.readings[ANGLE.name]) for body in tracked.bodies]
    for name, values in (*tracked.control.items(), *angles):
        if np.isfinite(values[i]):
            channel = CHANNELS.get(name)
            said = f"{values[i]:.4g}" if channel is None else channel.said(float(values[i]))
            words.append(f"{name if channel is None else channel.title} {said}")
    return ", ".join(words).replace("°", " deg")  # letters of OpenCV before 5 are ASCII
