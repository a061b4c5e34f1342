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
        settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(dictionary, settings)
        first = self._find(image)
        self.numbers = sorted(first)
        if len(first) < 2:
            raise ConfigError(
                f"{len(first)} tags of {family} are seen in the first frame; allowed: at least 2 "
                f"with a white border; --tags {'|'.join(FAMILIES)} tells the family"
            )
        self.radius_px = 0.0
        self.places = np.array([_centre(first[number]) for number in self.numbers])

    def _find(self, image: Image) -> dict[int, np.ndarray]:
        import cv2

        corners, numbers, _ = self._detector.detectMarkers(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
        if numbers is None:
            return {}
        found = zip(numbers.ravel().tolist(), corners, strict=True)
        return {number: each.reshape(4, 2).astype(float) for number, each in found}

    def step(self, image: Image) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Find the tags in a frame.

        Args:
            image: in blue, green and red.

        Returns:
            Centres (n, 2), the share of each that is seen (n,), and corners (n, 4, 2); NaN and 0
            where one is lost.
        """
        there = self._find(image)
        corners = np.full((len(self.numbers), 4, 2), np.nan)
        for i, number in enumerate(self.numbers):
            if number in there:
                corners[i] = there[number]
        seen = np.isfinite(corners[:, 0, 0]).astype(float)
        return np.array([_centre(each) for each in corners]), seen, corners


def _centre(corners: np.ndarray) -> np.ndarray:
    """Where the diagonals meet, which perspective does not move."""
    a, b, c, d = corners
    first, second = c - a, d - b
    across = first[0] * second[1] - first[1] * second[0]
    share = ((b - a)[0] * second[1] - (b - a)[1] * second[0]) / across
    return np.asarray(a + share * first)
