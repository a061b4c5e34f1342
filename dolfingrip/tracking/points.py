"""Points over frames: where they are in the picture, and which of them were lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from dolfingrip.tracking.plane import Length

ORDINARY_PX: Final = 0.3
"""Standard deviation of a place where its jumps do not tell it."""
LEAST_PX: Final = {"dots": 0.1, "tags": 0.03}
"""The least one: what a codec keeps from frame to frame shows in no jump."""
CORNER: Final = 3.0
"""Standard deviation of a tag's corner by that of its centre."""
HIDDEN: Final = 0.6
"""Shift of a dot's middle by its radius and the share that is hidden."""


@dataclass(frozen=True)
class TrackedPoints:
    """Points that keep their identity.

    Attributes:
        names: of the frames.
        time_s: (frames,) since the first frame; NaN for pictures.
        px: (frames, points, 2); NaN where a point was lost.
        seen: (frames, points) share of each that is seen.
        corners_px: (frames, points, 4, 2) of tags; None of dots.
        radius_px: of dots, whose middle is uncertain where a part is hidden; 0: of tags.
        unit: ``mm`` where another program has turned pixels into it.
        shared_px: (draws, frames, points, 2) errors that all frames have in common; None: none.
    """

    names: list[str]
    time_s: np.ndarray
    px: np.ndarray
    seen: np.ndarray
    corners_px: np.ndarray | None = None
    radius_px: float = 0.0
    unit: str = "px"
    shared_px: np.ndarray | None = None

    def part(self, points: np.ndarray) -> TrackedPoints:
        """Some of the points, in an order of their own.

        Args:
            points: (n,) their numbers.
        """
        corners = None if self.corners_px is None else self.corners_px[:, points]
        px, seen = self.px[:, points], self.seen[:, points]
        shared = None if self.shared_px is None else self.shared_px[:, :, points]
        return replace(self, px=px, seen=seen, corners_px=corners, shared_px=shared)

    def noise_px(self) -> np.ndarray:
        """(frames, points) standard deviations of the places.

        Third differences leave out what moves smoothly. Of pictures, whose states are far apart, an
        ordinary one is taken. A dot that is partly hidden has more, by the part that is.
        """
        hidden = HIDDEN * self.radius_px * (1 - self.seen)
        least = LEAST_PX["dots" if self.corners_px is None else "tags"]
        return np.asarray(np.hypot(np.maximum(self._jumps_px(), least), hidden))

    def _jumps_px(self) -> np.ndarray:
        """(points,) standard deviations by how much places jump from frame to frame."""
        std_px = np.full(self.px.shape[1], ORDINARY_PX)
        if len(self.time_s) < 8 or not np.isfinite(self.time_s).all():
            return std_px
        jumps = np.diff(self.px, 3, axis=0) / np.sqrt(20)
        for i in range(len(std_px)):
            finite = jumps[:, i][np.isfinite(jumps[:, i])]
            if len(finite) > 10:
                std_px[i] = 1.4826 * float(np.median(np.abs(finite - np.median(finite))))
        return std_px


@dataclass(frozen=True)
class Watched:
    """Points, corners and light that one pass over the frames has found.

    Attributes:
        points: of all fingers.
        fingers: numbers of the points along each finger, from the clamp.
        corners: places on the sheet and in the picture (px) in frames that show the sheet.
        light: (frames,) brightness.
        size_px: width and height.
        lengths: by which another program has calibrated them.
        in_space: whether a motion capture has measured them.
        notes: sentences on the points.
        doubts: sentences on what may be wrong with them.
        outlines: (n, 2) px of a finger without marks, by frame.
    """

    points: TrackedPoints
    fingers: list[np.ndarray]
    corners: list[tuple[np.ndarray, np.ndarray]]
    light: np.ndarray
    size_px: tuple[int, int]
    lengths: Sequence[Length] = ()
    in_space: bool = False
    notes: Sequence[str] = ()
    doubts: Sequence[str] = ()
    outlines: Sequence[np.ndarray] = ()
