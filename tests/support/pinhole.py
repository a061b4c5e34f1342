"""A pinhole camera in space, which sees a plane of bending, and a reader who thinks it is square.

Its matrix is made from where it stands and which way it looks, as in any textbook, and shares
nothing with the package's formula of the tilt.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pinhole:
    """A camera that is turned about z, then tipped about its own horizontal axis.

    Attributes:
        about_z_deg, about_x_deg: its turns from the plane's normal, which is y.
        distance_mm: from the place in the middle of its picture.
        centre_mm: x and z of that place.
        focal_px: focal length.
    """

    about_z_deg: float
    about_x_deg: float
    distance_mm: float
    centre_mm: tuple[float, float]
    focal_px: float = 1000.0

    def pixels(self, places_mm: np.ndarray) -> np.ndarray:
        """Picture (…, 2) of places (…, 2) in the plane, u towards x and v towards z."""
        z_turn, x_turn = np.radians([self.about_z_deg, self.about_x_deg])
        yaw = np.array([
            [np.cos(z_turn), np.sin(z_turn), 0], [-np.sin(z_turn), np.cos(z_turn), 0], [0, 0, 1],
        ])  # fmt: skip
        pitch = np.array([
            [1, 0, 0], [0, np.cos(x_turn), -np.sin(x_turn)], [0, np.sin(x_turn), np.cos(x_turn)],
        ])  # fmt: skip
        axes = yaw @ pitch  # columns: right, towards the camera, up of the picture
        middle = np.array([self.centre_mm[0], 0.0, self.centre_mm[1]])
        stands = middle + self.distance_mm * axes[:, 1]
        solid = np.stack([places_mm[..., 0], 0 * places_mm[..., 0], places_mm[..., 1]], axis=-1)
        right, towards, up = np.moveaxis((solid - stands) @ axes, -1, 0)
        return self.focal_px * np.stack([right / -towards, up / -towards], axis=-1)

    def read(
        self, places_mm: np.ndarray, line_mm: np.ndarray, ruler_mm: np.ndarray | None = None
    ) -> np.ndarray:
        """Places (…, 2) from the clamp by who takes the camera for a square one.

        Args:
            places_mm: (…, 2) to be read; the clamp is at the origin.
            line_mm: (2, 2) line of the markers at rest, which is taken for z.
            ruler_mm: (2, 2) ends of what tells the scale; None: the scale in the picture's middle.
        """
        clamp, start, end = self.pixels(np.array([[0.0, 0.0], *line_mm]))
        along = (end - start) / np.linalg.norm(end - start)
        across = np.array([along[1], -along[0]])
        per_px = self.distance_mm / self.focal_px
        if ruler_mm is not None:
            ends = self.pixels(ruler_mm)
            per_px = np.linalg.norm(np.diff(ruler_mm, axis=0)) / np.linalg.norm(ends[1] - ends[0])
        return per_px * (self.pixels(places_mm) - clamp) @ np.stack([across, along], axis=1)
