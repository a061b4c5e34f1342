"""A bar along x with a closed cavity, as the triangles of two boxes, and as a STL file."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

LOW_MM, HIGH_MM = np.array([0.0, -8.0, 0.0]), np.array([50.0, 8.0, 14.0])
INNER_LOW_MM, INNER_HIGH_MM = np.array([6.0, -5.0, 5.0]), np.array([46.0, 5.0, 11.0])
CAVITY_MM3 = float(np.prod(INNER_HIGH_MM - INNER_LOW_MM))
VOLUME_MM3 = float(np.prod(HIGH_MM - LOW_MM)) - CAVITY_MM3


def box(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (8, 3) of a box, and its triangles (12, 3) as seen from outside."""
    corners = np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)])
    faces = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    return corners, np.array([half for a, b, c, d in faces for half in ((a, b, c), (a, c, d))])


def triangles() -> tuple[np.ndarray, np.ndarray]:
    """Points (16, 3) in mm, and triangles (24, 3), as seen from outside of the solid."""
    outer, inner = box(LOW_MM, HIGH_MM), box(INNER_LOW_MM, INNER_HIGH_MM)
    return np.vstack([outer[0], inner[0]]), np.vstack([outer[1], 8 + inner[1][:, ::-1]])


def stl(file: Path, header: bytes = b"bar", behind: bytes = b"", scale: float = 1.0) -> Path:
    """Write a binary STL file.

    Args:
        file: that is written.
        header: its text at the beginning.
        behind: what follows the last triangle.
        scale: units of length of the file for each mm.
    """
    points, rows = triangles()
    data = [struct.pack("<12fH", 0, 0, 0, *(scale * points[row]).ravel(), 0) for row in rows]
    file.write_bytes(
        header.ljust(80, b" ") + struct.pack("<I", len(rows)) + b"".join(data) + behind
    )
    return file
