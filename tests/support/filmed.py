"""Frames of an arc with dots in front of the printed sheet, drawn by a camera that is known."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path

import av
import cv2
import numpy as np

from dolfingrip.tracking.sheet import SHEETS

RED = (40, 40, 215)
FINE = 4
"""Pixels of the drawing in a pixel of the frame, along each side."""


@dataclass(frozen=True)
class Filmed:
    """A camera in front of the sheet.

    Attributes:
        size_px: width and height of its frames.
        tilt_deg, way_deg: its angle against the sheet's normal, and the way it is turned.
        distance_mm: to the middle of the view.
        focal: by the longer side.
        k1: distortion.
        front_mm: of the dots before the sheet.
        sheet: whether it is there.
    """

    size_px: tuple[int, int] = (960, 720)
    tilt_deg: float = 6.0
    way_deg: float = 40.0
    distance_mm: float = 420.0
    focal: float = 0.9
    k1: float = 0.0
    front_mm: float = 10.0
    sheet: bool = True

    @cached_property
    def matrix(self) -> np.ndarray:
        focal = self.focal * max(self.size_px)
        middle = (np.array(self.size_px) - 1) / 2
        return np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])

    @cached_property
    def turn(self) -> np.ndarray:
        tilt, way = np.radians([self.tilt_deg, self.way_deg])
        return tilt * np.array([np.cos(way), np.sin(way), 0.0])

    @cached_property
    def place(self) -> np.ndarray:
        target = np.array([0.0, 95.0, 0.0])
        return np.array([0, 0, self.distance_mm]) - cv2.Rodrigues(self.turn)[0] @ target

    def pixels(self, places_mm: np.ndarray, front_mm: float | None = None) -> np.ndarray:
        """Where places (n, 2) in a plane in front of the sheet are seen, u and v."""
        front = self.front_mm if front_mm is None else front_mm
        if not len(places_mm):
            return np.zeros((0, 2))
        solid = np.column_stack([places_mm, np.full(len(places_mm), -front)])
        lens = np.array([self.k1, 0, 0, 0])
        return cv2.projectPoints(solid, self.turn, self.place, self.matrix, lens)[0].reshape(-1, 2)

    @cached_property
    def background(self) -> np.ndarray:
        width, height = self.size_px
        if not self.sheet:
            return np.full((height, width, 3), 215, np.uint8)
        page, half = SHEETS["a4"], 260
        board = np.full((half * FINE * 2, half * FINE * 2), 225, np.uint8)
        cells = (np.array(page.squares) * page.square_mm * FINE).astype(int)
        bits = np.where(page.bits, 30, 240).astype(np.uint8)
        corner = np.round((page.corner_mm + half) * FINE).astype(int)
        area = np.s_[corner[1] : corner[1] + cells[1], corner[0] : corner[0] + cells[0]]
        board[area] = cv2.resize(bits, cells.tolist(), interpolation=cv2.INTER_NEAREST)
        axes = (np.arange(2 * width) / 2 - 0.25, np.arange(2 * height) / 2 - 0.25)
        grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 1, 2)
        lens = np.array([self.k1, 0, 0, 0])
        rays = cv2.undistortPoints(grid, self.matrix, lens).reshape(-1, 2)
        rotation = cv2.Rodrigues(self.turn)[0]
        across = np.column_stack([rotation[:, 0], rotation[:, 1], self.place])
        mm = np.column_stack([rays, np.ones(len(rays))]) @ np.linalg.inv(across).T
        at = ((mm[:, :2] / mm[:, 2:] + half) * FINE - 0.5).astype(np.float32)
        maps = at.reshape(2 * height, 2 * width, 2)
        fine = cv2.remap(board, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderValue=225)
        return cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA)[..., None].repeat(
            3, 2
        )

    def frame(
        self,
        places_mm: np.ndarray,
        radius_mm: float = 1.5,
        colour: tuple[int, int, int] = RED,
        noise: float = 2.0,
        seed: int = 0,
    ) -> np.ndarray:
        """A frame with dots at places (n, 2), u and v."""
        found = self.background.copy()
        self.add(found, self.pixels(places_mm), radius_mm * self.px_per_mm, colour)
        grain = np.random.default_rng(seed).normal(0, noise, found.shape)
        return np.clip(np.round(found + grain), 0, 255).astype(np.uint8)

    @property
    def px_per_mm(self) -> float:
        return float(self.matrix[0, 0] / (self.distance_mm - self.front_mm))

    @staticmethod
    def add(
        image: np.ndarray, at_px: np.ndarray, radius_px: float, colour: tuple[int, ...]
    ) -> None:
        """Draw discs whose edges cover parts of pixels."""
        for u, v in at_px:
            x, y, size = int(u) - 20, int(v) - 20, 41
            if min(x, y) < 0 or x + size > image.shape[1] or y + size > image.shape[0]:
                continue
            grid = (np.arange(size * 8) + 0.5) / 8 - 0.5
            inside = (grid[None] + x - u) ** 2 + (grid[:, None] + y - v) ** 2 < radius_px**2
            share = inside.reshape(size, 8, size, 8).mean(axis=(1, 3))[..., None]
            part = image[y : y + size, x : x + size]
            part[:] = np.round(part * (1 - share) + np.array(colour) * share).astype(np.uint8)


def arc(
    bend_deg: float, count: int = 6, length_mm: float = 60.0, first_mm: float = 5.0
) -> np.ndarray:
    """Places (n, 2), u and v, of points along an arc from the clamp that bends to the right."""
    along = np.linspace(first_mm, length_mm, count)
    curvature = np.radians(bend_deg) / length_mm
    if abs(curvature) < 1e-12:
        return np.column_stack([np.zeros(count), along])
    turns = curvature * along
    return np.column_stack([1 - np.cos(turns), np.sin(turns)]) / curvature


def write(file: Path, images: list[np.ndarray], rate_hz: float = 30.0, crf: int = 16) -> None:
    """Write frames as a video in H.264, whose colour is at the left one of two pixels."""
    with av.open(str(file), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(rate_hz).limit_denominator(1000))
        stream.height, stream.width = images[0].shape[:2]
        stream.pix_fmt, stream.options = "yuv420p", {"crf": str(crf)}
        for image in images:
            full = av.VideoFrame.from_ndarray(image, format="bgr24").reformat(format="yuv444p")
            y, *colours = full.to_ndarray()
            kernels = np.array([0.25, 0.5, 0.25]), np.array([0.5, 0.5])
            left = [
                cv2.sepFilter2D(colour, -1, *kernels, anchor=(1, 0))[::2, ::2].ravel()
                for colour in colours
            ]
            planes = np.concatenate([y.ravel(), *left]).reshape(-1, image.shape[1])
            container.mux(stream.encode(av.VideoFrame.from_ndarray(planes, format="yuv420p")))
        container.mux(stream.encode())
