"""Videos: pictures of one size, each with words above it, as an MP4 and as a GIF."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib.util import find_spec
from io import BytesIO
from itertools import zip_longest
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.font_manager import findfont
from PIL import Image as Pillow
from PIL import ImageDraw, ImageFont

from dolfingrip.charts.theme import INK
from dolfingrip.files import video, whole
from dolfingrip.report.scene import Image

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class VideoPolicy:
    """How long a video is and how it looks.

    Attributes:
        frame_ms: time for which a picture is shown.
        seconds: length of a video where none is asked for.
        height_px: height of the shapes in a video.
        label_px: height of the letters above a picture.
        large_px: height of the letters above a picture with scales.
        gif_bytes: size of a GIF above which every second picture is left out.
    """

    frame_ms: int = 40
    seconds: float = 10.0
    height_px: int = 880
    label_px: int = 26
    large_px: int = 40
    gif_bytes: int = 3_000_000

    def frames(self, seconds: float | None = None) -> int:
        """Return the number of pictures in a video.

        Args:
            seconds: its length; None: ``seconds`` of the policy.
        """
        return round(1000 * (seconds or self.seconds) / self.frame_ms)


POLICY: Final = VideoPolicy()

FIGURE_SPACE: Final = "\u2007"
"""A space as wide as a digit."""


def write(stem: Path, images: Sequence[Image], policy: VideoPolicy = POLICY) -> list[Path]:
    """Write pictures as a GIF of half their size, and as an MP4 in H.264.

    The GIF has fewer pictures, each shown for longer, where it would be too large to send.

    Args:
        stem: path of the files, without their suffix.
        images: pictures of one size, shape (height, width, 3).
        policy: has the time of a picture, and the largest size of the GIF.

    Returns:
        The files; no MP4 where PyAV is missing, and a warning says so.
    """
    height, width = (length // 2 for length in images[0].shape[:2])
    frames = [Pillow.fromarray(image).resize((width, height)) for image in images]
    moving, shown = stem.with_suffix(".gif"), stem.with_suffix(".mp4")
    shown_ms, packed = policy.frame_ms, _gif(frames, policy.frame_ms)
    while len(packed) > policy.gif_bytes and len(frames) > 2:
        frames, shown_ms = frames[::2], 2 * shown_ms
        packed = _gif(frames, shown_ms)
    whole.write(moving, packed)
    if find_spec("av") is None:
        _LOG.warning("no %s: pip install av (dolfingrip's extra video)", shown)
        return [moving]
    with video.growing(shown, Fraction(1000, policy.frame_ms), "rgb24") as add:
        for image in images:
            add(image)
    return [moving, shown]


def _gif(frames: Sequence[Pillow.Image], frame_ms: int) -> bytes:
    content = BytesIO()
    every = max(len(frames) // 8, 1)  # one palette for all, lest still places change their colour
    seen = np.concatenate([np.asarray(frame) for frame in frames[::every]])
    palette = Pillow.fromarray(seen).quantize(256)
    first, *others = [
        frame.quantize(palette=palette, dither=Pillow.Dither.NONE) for frame in frames
    ]
    first.save(
        content, "GIF", save_all=True, append_images=others, duration=frame_ms, loop=0,
        optimize=True,
    )  # fmt: skip
    return content.getvalue()


def titled(
    images: Iterable[Image], texts: Sequence[str], size_px: int = POLICY.label_px
) -> list[Image]:
    """Set texts above the pictures of a video, in one size and at one place.

    Numbers at the same place of the texts take the same width, so that nothing jitters.

    Args:
        images: of one size, shape (height, width, 3).
        texts: one line each.
        size_px: height of the letters, at most.

    Returns:
        Pictures as of :func:`labelled`.
    """
    parts = [re.split(r"(-?[\d.]+)", text) for text in texts]
    width = [max(map(len, column)) for column in zip_longest(*parts, fillvalue="")]
    for pieces in parts:  # every second part is a number
        numbers = zip(pieces[1::2], width[1::2], strict=False)
        pieces[1::2] = [number.rjust(wide, FIGURE_SPACE) for number, wide in numbers]
    still = ["".join(pieces) for pieces in parts]
    widest = max(still, key=_font(size_px).getlength)
    return [labelled(i, text, size_px, widest) for i, text in zip(images, still, strict=True)]


def labelled(
    image: Image, text: str, size_px: int = POLICY.label_px, widest: str | None = None
) -> Image:
    """Set a text above a picture, in letters that are as small as the picture requires.

    Args:
        image: picture of shape (height, width, 3).
        text: one line.
        size_px: height of the letters, at most.
        widest: text that stands amid the picture, and where this one begins; None: this one.

    Returns:
        A picture that is higher by twice the letters' height.
    """
    size, width, widest = size_px, image.shape[1], widest or text
    while size > 8 and _font(size).getlength(widest) > 0.96 * width:
        size -= 1
    strip = Pillow.new("RGB", (width, 2 * size_px), "white")
    place = ((width - _font(size).getlength(widest)) / 2, size_px)
    ImageDraw.Draw(strip).text(place, text, fill=INK, font=_font(size), anchor="lm")
    return np.concatenate([np.asarray(strip), image])


def _font(size_px: int) -> ImageFont.FreeTypeFont:
    """The font of all pictures; matplotlib ships it."""
    return ImageFont.truetype(findfont("DejaVu Sans"), size_px)
