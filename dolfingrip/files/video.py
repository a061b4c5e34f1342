"""MP4 videos in H.264 that grow by pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Literal

import numpy as np

from dolfingrip.files import whole


@contextmanager
def growing(
    path: Path,
    rate_hz: Fraction,
    order: Literal["rgb24", "bgr24"],
    options: Mapping[str, str] = {},
) -> Iterator[Callable[[np.ndarray], None]]:
    """Write a video, one picture after the other; it takes its name when the block ends.

    Args:
        path: target; an existing file is replaced.
        rate_hz: pictures per second.
        order: of the colours in a picture.
        options: of the encoder x264.

    Yields:
        A function that adds a picture of 8 bits, (height, width, 3), all of one size. Of an odd
        height or width the last row or column is left out, as H.264 needs.

    Raises:
        WriteError: one line.
    """
    import av

    with whole.replacing(path) as (partial,), av.open(str(partial), "w", format="mp4") as container:
        streams: list[av.VideoStream] = []

        def add(image: np.ndarray) -> None:
            height, width = (length // 2 * 2 for length in image.shape[:2])
            if not streams:  # its size is told by the first picture
                stream = container.add_stream("libx264", rate=rate_hz, options=dict(options))
                stream.height, stream.width, stream.pix_fmt = height, width, "yuv420p"
                streams.append(stream)
            cut = np.ascontiguousarray(image[:height, :width])
            container.mux(streams[0].encode(av.VideoFrame.from_ndarray(cut, format=order)))

        yield add
        for stream in streams:
            container.mux(stream.encode())
