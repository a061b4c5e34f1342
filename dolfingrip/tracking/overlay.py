"""Pictures and a video of what was found: points with their numbers, the line along each finger."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip.files import whole
from dolfingrip.tracking.frames import Image

COLOURS: Final = ((255, 120, 0), (0, 140, 255), (40, 180, 40), (200, 60, 200))
"""Of fingers, in blue, green and red."""
HEIGHT_PX: Final = 540
"""Of the video, at most."""
HALO: Final = (255, 255, 255)
OUTLINE: Final = (0, 220, 255)


def drawn(
    image: Image, fingers: Sequence[np.ndarray], text: str, outline: np.ndarray | None = None,
    scale: float = 1.0,
) -> Image:  # fmt: skip
    """Draw points over a picture.

    Args:
        image: in blue, green and red; it is not changed.
        fingers: (n, 2) places of each finger's points in order, px of the frame; NaN: lost.
        text: one line in the corner.
        outline: (n, 2) of a simulated finger, px of the frame; None or without points: none.
        scale: size of the picture drawn by that of the frame.
    """
    import cv2

    height, width = (max(2 * round(n * scale / 2), 2) for n in image.shape[:2])
    picture = (
        cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
        if scale != 1
        else image.copy()
    )
    thick = max(1, round(height / 500))
    if outline is not None and len(outline):
        shape = np.round((outline + 0.5) * scale - 0.5).astype(np.int32)
        cv2.polylines(picture, [shape], True, OUTLINE, thick, cv2.LINE_AA)
    for i, points in enumerate(fingers):
        places: Any = np.round((points + 0.5) * scale - 0.5).tolist()
        there = {n: (int(u), int(v)) for n, (u, v) in enumerate(places, 1) if np.isfinite(u)}
        colour = COLOURS[i % len(COLOURS)]
        for a, b in pairwise(there.values()):
            cv2.line(picture, a, b, colour, thick, cv2.LINE_AA)
        for number, (u, v) in there.items():
            cv2.circle(picture, (u, v), 5 * thick, HALO, thick + 1, cv2.LINE_AA)
            cv2.circle(picture, (u, v), 5 * thick, colour, thick, cv2.LINE_AA)
            _write(picture, str(number), (u + 9 * thick, v - 2 * thick), thick)
    _write(picture, text, (8 * thick, 20 * thick), thick)
    return np.asarray(picture)


def _write(image: Any, text: str, at: tuple[int, int], thick: int) -> None:
    import cv2

    font, size = cv2.FONT_HERSHEY_SIMPLEX, 0.45 * thick
    (width, height), below = cv2.getTextSize(text, font, size, thick)
    cv2.rectangle(image, (at[0], at[1] - height), (at[0] + width, at[1] + below), HALO, -1)
    cv2.putText(image, text, at, font, size, (30, 30, 30), thick, cv2.LINE_AA)


def picture(file: Path, image: Image) -> None:
    """Write a picture as PNG.

    Args:
        file: target.
        image: in blue, green and red.
    """
    import cv2

    whole.write(file, cv2.imencode(".png", image)[1].tobytes())
