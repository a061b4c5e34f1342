"""Frames of a video or of pictures, one after another, with the times of the container.

Both are untrusted input: formats, sizes and counts are limited, and what cannot be decoded is
refused in one line.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow
from PIL import ImageOps, UnidentifiedImageError

from dolfingrip.sections.errors import ConfigError

Image = npt.NDArray[np.uint8]
"""A picture in blue, green and red, shape (height, width, 3)."""

PICTURES: Final = (".jpg", ".jpeg", ".png")

FORMATS: Final = frozenset({"mov", "matroska", "avi", "mpegts", "mpeg", "asf", "gif"})
"""Containers that are read; playlists, which open other files, are none of them."""


@dataclass(frozen=True, slots=True)
class FramePolicy:
    """Limits of what is decoded.

    Attributes:
        most_frames: of a video, or pictures.
        most_pixels: of a frame.
        least_px: smallest width and height of a frame.
        early_s: time by which a video may end before the length that it states.
    """

    most_frames: int = 200_000
    most_pixels: int = 50_000_000
    least_px: int = 64
    early_s: float = 0.5


POLICY: Final = FramePolicy()


@dataclass(frozen=True, slots=True)
class Frame:
    """One picture.

    Attributes:
        number: from 0 on.
        time_s: since the first frame, by the container; NaN for pictures.
        image: turned as it is shown.
        name: of the picture's file; the frame's number in a video.
    """

    number: int
    time_s: float
    image: Image
    name: str


class FrameSource(Protocol):
    """Frames that can be gone through several times.

    Attributes:
        expected: number of frames, as far as it is told.
        name: for messages.
    """

    expected: int
    name: str

    def __iter__(self) -> Iterator[Frame]: ...


def open_frames(files: Sequence[Path], until_s: float = math.inf) -> FrameSource:
    """Make the frames of one video or of several pictures.

    Args:
        files: a video, or JPEG and PNG pictures.
        until_s: time at which a video is left (s).

    Raises:
        ConfigError: one line, where there is no such file, or both kinds.
    """
    for file in files:
        if not file.is_file():
            raise ConfigError(f"{file}: no such file; allowed: a video, or JPEG and PNG pictures")
    pictures = [file for file in files if file.suffix.lower() in PICTURES]
    if pictures and len(pictures) == len(files):
        if len(files) > POLICY.most_frames:
            raise ConfigError(f"{len(files)} pictures: allowed: up to {POLICY.most_frames}")
        return PictureFrames(pictures)
    if len(files) != 1:
        raise ConfigError(
            f"{files[0]} and {len(files) - 1} more: allowed: one video, or JPEG and PNG pictures"
        )
    return VideoFrames(files[0], until_s)


class PictureFrames:
    """Pictures of one size, in the order in which they were given.

    Args:
        files: JPEG or PNG.
    """

    def __init__(self, files: Sequence[Path]) -> None:
        self._files, self.expected, self.name = files, len(files), str(files[0])

    def __iter__(self) -> Iterator[Frame]:
        size: tuple[int, int] | None = None
        for number, file in enumerate(self._files):
            try:
                with Pillow.open(file, formats=("JPEG", "PNG")) as opened:
                    _check(str(file), *opened.size)
                    turned = opened.convert("RGB")
                    ImageOps.exif_transpose(turned, in_place=True)
            except (UnidentifiedImageError, OSError, SyntaxError, ValueError) as error:
                if isinstance(error, ConfigError):
                    raise
                raise ConfigError(
                    f"{file}: cannot be decoded ({error}); allowed: a whole JPEG or PNG"
                ) from None
            if size is not None and turned.size != size:
                raise ConfigError(
                    f"{file}: {turned.width} × {turned.height} px, and {self._files[0].name} is "
                    f"{size[0]} × {size[1]} px; allowed: pictures of one size, of one camera that "
                    "stands still"
                )
            size = turned.size
            yield Frame(number, math.nan, np.asarray(turned)[:, :, ::-1].copy(), file.name)


class VideoFrames:
    """The frames of a video file.

    Args:
        file: in a container of :data:`FORMATS`.
        until_s: time at which it is left (s).

    Raises:
        ConfigError: one line, where it cannot be opened, or is too large.
    """

    def __init__(self, file: Path, until_s: float = math.inf) -> None:
        self._file, self._until_s, self.name = file, until_s, str(file)
        with self._open() as container:
            stream = container.streams.video[0]
            _check(str(file), stream.codec_context.width, stream.codec_context.height)
            stream_s = stream.duration and float(stream.duration * stream.time_base)
            self._length_s = stream_s or float(container.duration or 0) / 1e6
            rate = float(stream.average_rate or 30)
            count = stream.frames or round(self._length_s * rate)
            self.expected = min(count, math.ceil(min(until_s, 1e6) * rate))
        if self.expected > POLICY.most_frames:
            raise ConfigError(
                f"{file}: {self.expected} frames; allowed: up to {POLICY.most_frames}; "
                "--until SECONDS reads its beginning"
            )

    def _open(self) -> Any:
        try:
            import av
        except ImportError:
            raise ConfigError(
                f"{self._file}: no PyAV to decode it: pip install dolfingrip[track]"
            ) from None
        try:
            container = av.open(str(self._file), options={"protocol_whitelist": "file"})
        except (av.FFmpegError, ValueError) as error:
            why = getattr(error, "strerror", error)
            raise self._refuse(f"no video that can be opened ({why})") from None
        if not container.streams.video or not FORMATS & set(container.format.name.split(",")):
            container.close()
            raise self._refuse("no video")
        return container

    def _refuse(self, what: str) -> ConfigError:
        return ConfigError(
            f"{self._file}: {what}; allowed: a whole video, as of a camera or a phone (MP4, MOV, "
            "MKV, WebM, AVI, GIF), or JPEG and PNG pictures"
        )

    def __iter__(self) -> Iterator[Frame]:
        import av
        from av.video.reformatter import Interpolation

        # a codec keeps colour at half the resolution: in blocks it moves a dot's middle by 0.1 px
        smooth = Interpolation.BILINEAR | Interpolation.ACCURATE_RND | Interpolation.FULL_CHR_H_INT
        first, time_s, number = None, 0.0, 0
        with self._open() as container:
            stream = container.streams.video[0]
            stream.thread_type = "AUTO"
            stream.codec_context.options = {"err_detect": "explode"}
            try:
                for decoded in container.decode(stream):
                    if decoded.pts is None or decoded.is_corrupt:
                        raise self._broken(number, time_s, "it is damaged")
                    first = decoded.time if first is None else first
                    time_s = float(decoded.time - first)
                    if time_s > self._until_s:
                        return
                    if number >= POLICY.most_frames:
                        raise self._broken(number, time_s, f"{POLICY.most_frames} are allowed")
                    _check(str(self._file), decoded.width, decoded.height)
                    image = decoded.to_ndarray(format="bgr24", interpolation=smooth)
                    turns = round(decoded.rotation / 90) % 4
                    yield Frame(
                        number, time_s, np.ascontiguousarray(np.rot90(image, turns)), f"{number}"
                    )
                    number += 1
            except av.FFmpegError as error:
                raise self._broken(number, time_s, str(error.strerror)) from None
        if not number:
            raise self._refuse("not one frame can be decoded")
        if time_s < min(self._length_s, self._until_s) - max(POLICY.early_s, 2 * time_s / number):
            raise self._broken(number, time_s, f"it states {self._length_s:.1f} s")

    def _broken(self, number: int, time_s: float, why: str) -> ConfigError:
        return ConfigError(
            f"{self._file}: ends after {number} frames, at {time_s:.2f} s ({why}); allowed: a "
            f"whole video; --until {max(time_s - 0.1, 0):.1f} reads what is there"
        )


def _check(name: str, width: int, height: int) -> None:
    """Refuse frames that are too large, or too small to show anything."""
    if width * height > POLICY.most_pixels or min(width, height) < POLICY.least_px:
        raise ConfigError(
            f"{name}: {width} × {height} px; allowed: at least {POLICY.least_px} px on each side, "
            f"and up to {POLICY.most_pixels / 1e6:.0f} million pixels"
        )
