"""The overlay of a video or of pictures, and pictures of doubtful frames."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
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


@contextmanager
def beside_refusal(source: FrameSource | None, out: Path) -> Iterator[list[Watched]]:
    """Write the first frame with what was found in it, where a block refuses the frames.

    Args:
        source: the frames; None: another program has tracked them.
        out: folder of the picture.

    Yields:
        A list that takes what was seen in them.
    """
    sights: list[Watched] = []
    try:
        yield sights
    except ConfigError as error:
        if source is None:
            raise
        try:
            first = next(iter(source))
        except ConfigError:
            raise error from None
        points = [error.places_px] if isinstance(error, Unseen) else []
        points += [seen.points.px[0, finger] for seen in sights for finger in seen.fingers]
        file = out / "seen.png"
        text = f"{source.name}: first frame"
        corners = [px for seen in sights for _, px in seen.corners[:1]]
        overlay.picture(file, overlay.drawn(first.image, [*points, *corners], text))
        raise ConfigError(f"{error}; {file} shows the first frame") from None


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
