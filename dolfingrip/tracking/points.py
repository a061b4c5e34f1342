"""Points over frames: where they are in the picture, and which of them were lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking.plane import Length

HIDDEN: Final = 0.6
"""Shift of a dot's middle by its radius and the share that is hidden."""


class Unseen(ConfigError):
    """Not all points that are sought are in the first frame.

    Attributes:
        places_px: (n, 2) of those that are.
    """

    def __init__(self, message: str, places_px: np.ndarray) -> None:
        super().__init__(message)
        self.places_px = places_px


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

    @property
    def marks_px(self) -> np.ndarray:
        """Places (frames, marks, 2) of the points, and of their corners behind them."""
        if self.corners_px is None:
            return self.px
        return np.concatenate([self.px, self.corners_px.reshape(len(self.px), -1, 2)], axis=1)

    @property
    def hidden_px(self) -> np.ndarray:
        """Standard deviations (frames, marks) by what is hidden of each; a tag is seen or not."""
        hidden = HIDDEN * self.radius_px * (1 - self.seen)
        return hidden if self.corners_px is None else np.zeros(self.marks_px.shape[:2])


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
