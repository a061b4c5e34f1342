"""ArUco and AprilTag tags in a frame: centre and corners, by their numbers."""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking.frames import Image

FAMILIES: Final = {
    "4x4": "DICT_4X4_50", "5x5": "DICT_5X5_50", "6x6": "DICT_6X6_50",
    "36h11": "DICT_APRILTAG_36h11", "25h9": "DICT_APRILTAG_25h9", "16h5": "DICT_APRILTAG_16h5",
}  # fmt: skip
"""OpenCV's dictionary by the name of a family of tags."""


class Tags:
    """Finds the tags of one family.

    Args:
        family: one of :data:`FAMILIES`.
        image: the first frame, whose tags are followed.

    Attributes:
        numbers: of the tags.
        places: (n, 2) their centres in the first frame, px.
        radius_px: 0, as a tag that is partly hidden is lost.

    Raises:
        ConfigError: one line, if fewer than two tags are seen.
    """

    def __init__(self, family: str, image: Image) -> None:
        import cv2

        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, FAMILIES[family]))
        settings = cv2.aruco.DetectorParameters()
        settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_CONTOUR
        self._detector = cv2.aruco.ArucoDetector(dictionary, settings)
        first = self._find(image)
        self.numbers = sorted(first)
        if len(first) < 2:
            raise ConfigError(
                f"{len(first)} tags of {family} are seen in the first frame; allowed: at least 2 "
                f"with a white border; --tags {'|'.join(FAMILIES)} tells the family"
            )
        self.radius_px = 0.0
        self.places = np.array([first[number].mean(axis=0) for number in self.numbers])

    def _find(self, image: Image) -> dict[int, np.ndarray]:
        import cv2

        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        corners, numbers, _ = self._detector.detectMarkers(grey)
        if numbers is None:
            return {}
        pairs = zip(numbers.ravel().tolist(), corners, strict=True)
        return {
            number: _sharpened(grey, quad.reshape(4, 2).astype(float)) for number, quad in pairs
        }

    def step(self, image: Image) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Find the tags in a frame.

        Args:
            image: in blue, green and red.

        Returns:
            Centres (n, 2), the share of each that is seen (n,), and corners (n, 4, 2); NaN and 0
            where one is lost.
        """
        there, lost = self._find(image), np.full((4, 2), np.nan)
        corners = np.array([there.get(number, lost) for number in self.numbers])
        seen = np.isfinite(corners[:, 0, 0]).astype(float)
        return corners.mean(axis=1), seen, corners


def _sharpened(grey: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Corners where lines meet that are fitted to a tag's black edges, along all of each."""
    import cv2

    away = np.arange(-2.5, 2.51, 0.25)
    lines = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        length = float(np.linalg.norm(end - start))
        along = (end - start) / length
        out = np.array([along[1], -along[0]])
        out *= np.sign(out @ (start - corners.mean(axis=0)))
        steps = np.linspace(0.15, 0.85, max(int(length), 8)) * length
        seen = (start + steps[:, None, None] * along + away[:, None] * out).astype(np.float32)
        values = cv2.remap(grey, seen[..., 0], seen[..., 1], cv2.INTER_LINEAR).astype(float)
        brighter = np.clip(np.gradient(values, axis=1), 0, None)  # from the tag to its border
        strength = brighter.sum(axis=1)
        clear = strength > 0.3 * np.median(strength)
        if clear.sum() < 4:
            return corners
        steps, edge = steps[clear], (brighter @ away)[clear] / strength[clear]
        for _ in range(2):
            slope, zero = np.polyfit(steps, edge, 1)
            off = np.abs(edge - zero - slope * steps)
            near = off <= 2 * np.sqrt(np.mean(off**2)) + 1e-9
            steps, edge = steps[near], edge[near]
        lines.append((start + zero * out, along + slope * out))
    points = []
    for (first, one), (second, other) in zip(np.roll(lines, 1, axis=0), lines, strict=True):
        step = np.linalg.solve(np.column_stack([one, -other]), second - first)
        points.append(first + step[0] * one)
    return np.array(points)
