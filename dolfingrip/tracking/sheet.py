"""The printed sheet: a ring of a ChArUco board, a frame for the clamp, and a ruler.

A corner of the chessboard is found to a twentieth of a pixel, and knows its place on the sheet. The
window amid the ring is white, for the finger in front of it. The sheet's coordinates are u to the
right and v downwards from the mark of the clamp (mm), and w into the paper.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip.files import whole
from dolfingrip.sections.units import UNITS_MM
from dolfingrip.tracking.frames import Image

CELLS: Final = 8
"""Cells of a chessboard's square along each side; a marker has six, with its border."""
CLAMP_MM: Final = (40.0, 18.0)
"""Width and height of the frame for the clamp."""
RULER_MM: Final = 100.0


@dataclass(frozen=True)
class PrintedSheet:
    """The layout of a page.

    Attributes:
        name: of the paper.
        size_mm: its width and height.
        squares: number of squares in a row and in a column.
        first: number of its first marker; smaller ones are left for tags on a finger.
        square_mm: side of a square.
        ring: squares of the ring's width.
    """

    name: str
    size_mm: tuple[float, float]
    squares: tuple[int, int]
    first: int
    square_mm: float = 18.0
    ring: int = 2

    @cached_property
    def board(self) -> Any:
        """OpenCV's board."""
        import cv2

        count = self.squares[0] * self.squares[1] // 2
        return cv2.aruco.CharucoBoard(
            self.squares, self.square_mm, 0.75 * self.square_mm,
            cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_250),
            np.arange(self.first, self.first + count),
        )  # fmt: skip

    @property
    def corner_mm(self) -> np.ndarray:
        """Place (2,) of the board's corner on the sheet, from the mark of the clamp."""
        width = self.squares[0] * self.square_mm
        return np.array([-width / 2, -self.ring * self.square_mm - CLAMP_MM[1]])

    @cached_property
    def bits(self) -> np.ndarray:
        """Cells (rows, columns), True where they are black."""
        rows, columns = self.squares[1] * CELLS, self.squares[0] * CELLS
        black = self.board.generateImage((columns, rows), marginSize=0, borderBits=1) < 128
        edge = self.ring * CELLS
        black[edge:-edge, edge:-edge] = False
        return np.asarray(black)

    @cached_property
    def _printed(self) -> np.ndarray:
        """Numbers of the corners amid four squares that are printed."""
        printed = np.ones(np.array(self.squares[::-1]) - 1, dtype=bool)
        inner = slice(self.ring - 1, 1 - self.ring)
        printed[inner, inner] = False
        return np.flatnonzero(printed)

    def find(self, image: Image) -> tuple[np.ndarray, np.ndarray]:
        """Find the corners in a picture.

        Args:
            image: in blue, green and red.

        Returns:
            Places on the sheet (n, 2) in mm, and in the picture (n, 2) in pixels.
        """
        import cv2

        detector = cv2.aruco.CharucoDetector(self.board)
        corners, numbers, _, _ = detector.detectBoard(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
        if numbers is None:
            return np.zeros((0, 2)), np.zeros((0, 2))
        numbers = numbers.ravel()
        kept = np.isin(numbers, self._printed)
        places = self.board.getChessboardCorners()[numbers[kept], :2] + self.corner_mm
        return places, corners.reshape(-1, 2)[kept].astype(float)

    def write(self, file: Path) -> None:
        """Write the page as a PDF of the paper's size.

        Args:
            file: target.
        """
        from matplotlib.backends.backend_pdf import FigureCanvasPdf
        from matplotlib.figure import Figure

        width, height = self.size_mm
        figure = Figure(figsize=(width / UNITS_MM["in"], height / UNITS_MM["in"]))
        axes = figure.add_axes((0, 0, 1, 1))
        left, top = self.corner_mm
        across, down = (n * self.square_mm for n in self.squares)
        axes.set_xlim(left + across / 2 - width / 2, left + across / 2 + width / 2)
        axes.set_ylim(top + down / 2 + height / 2, top + down / 2 - height / 2)
        axes.axis("off")
        fine = np.kron(self.bits, np.ones((24, 24), dtype=bool))  # no viewer blurs cells then
        axes.imshow(
            np.where(fine, 0, 255).astype(np.uint8), cmap="gray", vmin=0, vmax=255,
            extent=(left, left + across, top + down, top), interpolation="none",
        )  # fmt: skip
        half, high = CLAMP_MM[0] / 2, CLAMP_MM[1]
        axes.plot([-half, -half, half, half, -half], [0, -high, -high, 0, 0], "k-", lw=0.6)
        axes.plot([0, 0], [-4, 4], "k-", lw=0.6)
        axes.text(0, -high / 2, "clamp: its face on the line below,\nthe edge of the finger's back "
                  "on the mark", size=6, ha="center", va="center")  # fmt: skip
        low = top + down - self.ring * self.square_mm - 6
        axes.plot([-RULER_MM / 2, RULER_MM / 2], [low, low], "k-", lw=0.6)
        for tick in np.arange(0, RULER_MM + 1, 10):
            axes.plot(2 * [tick - RULER_MM / 2], [low, low - 3], "k-", lw=0.6)
        axes.text(0, low + 3, f"{RULER_MM:g} mm; print at 100 %, and measure this line", size=6,
                  ha="center", va="center")  # fmt: skip
        with whole.stream(file) as stream:
            FigureCanvasPdf(figure).print_pdf(stream)


SHEETS: Final = {
    "a4": PrintedSheet("A4", (210.0, 297.0), (10, 15), 50),
    "letter": PrintedSheet("letter", (215.9, 279.4), (11, 14), 130),
}
"""Sheets by the paper's name."""
