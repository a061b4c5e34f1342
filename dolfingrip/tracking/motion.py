"""Motion of a body's points, from which the noise of single frames is taken out.

For a second or two a slow body passes through one row of shapes: each place is a cubic of one
number, which says how far the body has moved (a principal curve, Hastie & Stuetzle 1989). That
number is free in each frame, so a stop or a turn is not smoothed away. What is left beside the
curves tells the noise of the video.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.signal import lfilter

from dolfingrip.tracking.points import TrackedPoints

Floats = np.ndarray

WINDOW: Final = 61
"""Frames that one row of shapes has."""
STEP: Final = 15
"""Frames from one row to the next."""
LEAST: Final = 12
"""Fewer frames tell no motion, and pictures without time tell none."""
DEGREES: Final = (1, 1, 1, 3, 3)
"""Degrees of the curves by round; straight lines begin."""
ORDINARY_PX: Final = 0.3
"""Standard deviation of a place where no motion tells it."""
SEEN_PX: Final = 0.1
"""Error by which that of a hidden part is weighed."""
ALIKE: Final = 0.9
"""Largest correlation of a frame's noise with the next one's."""
TINY: Final = 1e-12


@dataclass(frozen=True)
class Motion:
    """Places of marks, and their errors.

    Attributes:
        px: (frames, marks, 2); NaN where a mark was lost.
        std_px: (frames, marks) standard deviations, each mark and axis for itself.
        along_px: (frames, marks, 2) standard deviation of how far the body has moved, which moves
            all marks of a frame together.
        frame_px: (marks,) standard deviations in a single frame.
        alike: correlation of a frame's noise with the next one's.
    """

    px: Floats
    std_px: Floats
    along_px: Floats
    frame_px: Floats
    alike: float

    @property
    def single(self) -> Motion:
        """This motion with the errors of frames that know nothing of each other.

        Whoever takes the frames' errors for new ones each time, as a diagnosis does, averages them
        himself: with these he does not do so twice.
        """
        each_px = np.broadcast_to(self.frame_px * _lasting(self.alike), self.std_px.shape)
        return replace(self, std_px=each_px, along_px=np.zeros_like(self.px), alike=0.0)

    def jittered(self, generator: np.random.Generator) -> Floats:
        """Places (frames, marks, 2) with other noise.

        Args:
            generator: of random numbers.
        """
        return np.asarray(
            self.px
            + self.std_px[..., None] * self._noise(generator, self.px.shape)
            + self.along_px * self._noise(generator, (len(self.px), 1, 1))
        )

    def _noise(self, generator: np.random.Generator, shape: tuple[int, ...]) -> Floats:
        """Normal noise whose frames are alike."""
        new = np.sqrt(1 - self.alike**2)
        noise = generator.standard_normal(shape)
        noise[0] /= new
        return np.asarray(lfilter([new], [1.0, -self.alike], noise, axis=0))


def follow(points: TrackedPoints) -> Motion:
    """Find the motion of one body.

    Args:
        points: of it, as they were found in each frame.
    """
    marks, hidden = points.marks_px, points.hidden_px
    count = len(marks)
    if count < LEAST or not np.isfinite(points.time_s).all():
        std_px = np.hypot(ORDINARY_PX, hidden)
        along_px = np.zeros_like(marks)
        return Motion(marks, std_px, along_px, np.full(marks.shape[1], ORDINARY_PX), 0.0)
    places = np.nan_to_num(marks).reshape(count, -1)
    weight = np.repeat(1 / (1 + (hidden / SEEN_PX) ** 2), 2, axis=1)
    weight *= np.isfinite(marks).reshape(count, -1)
    length = min(WINDOW, count)
    starts = np.unique([*range(0, count - length, STEP), count - length])
    nearest = np.abs(np.arange(count)[:, None] - starts - length / 2).argmin(axis=1)
    curved, leverage, along = (np.empty_like(places) for _ in range(3))
    variances = []
    for i, start in enumerate(starts.tolist()):
        rows = slice(start, start + length)
        parts = _curves(places[rows], weight[rows])
        left = weight[rows] * (places[rows] - parts[0]) ** 2
        free = (weight[rows] > 0) - weight[rows] * (parts[1] + parts[2] ** 2)
        sums = [term.reshape(length, -1, 2).sum(axis=(0, 2)) for term in (left, free)]
        variances.append(sums[0] / np.maximum(sums[1], 1.0))
        for every, part in zip((curved, leverage, along), parts, strict=True):
            every[nearest == i] = part[nearest[rows] == i]
    frame_px = np.sqrt(np.max(variances, axis=0))  # noise of a still codec shows in no window
    left = np.sqrt(weight) * (places - curved)
    alike = float(np.clip((left[1:] * left[:-1]).sum() / ((left**2).sum() + TINY), 0.0, ALIKE))
    std_px = frame_px * _lasting(alike) * np.sqrt(leverage[:, ::2])
    px = np.where(np.isnan(marks), np.nan, curved.reshape(marks.shape))
    return Motion(px, std_px, frame_px[:, None] * along.reshape(marks.shape), frame_px, alike)


def _lasting(alike: float) -> float:
    """Factor by which the error of a mean is larger where each error is like the one before."""
    return float(np.sqrt((1 + alike) / (1 - alike)))


def _curves(places: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """Fit curves to coordinates (frames, n) of some weight, which is 0 where one is lost.

    Returns:
        Coordinates on the curves, the variance that is left of each by that of one frame, and the
        part of it that all coordinates of a frame have in common: its standard deviation.
    """
    off = (weight > 0) * (places - (weight * places).sum(axis=0) / (weight.sum(axis=0) + TINY))
    way = np.linalg.svd(off, full_matrices=False)[2][0]
    moved = (weight * off * way).sum(axis=1) / ((weight * way**2).sum(axis=1) + TINY)
    for degree in DEGREES:
        moved -= moved.mean()
        moved /= np.abs(moved).max() + TINY
        exponents = np.arange(degree + 1)
        powers = moved[:, None] ** exponents
        inverse = np.linalg.pinv(np.einsum("ia,in,ib->nab", powers, weight, powers), hermitian=True)
        curves = np.einsum("nab,ib,in,in->na", inverse, powers, weight, places, optimize=True)
        slopes = exponents * moved[:, None] ** np.maximum(exponents - 1, 0) @ curves.T
        size = (weight * slopes**2).sum(axis=1) + TINY
        moved = moved + (weight * slopes * (places - powers @ curves.T)).sum(axis=1) / size
    powers = moved[:, None] ** exponents
    leverage = np.einsum("ia,nab,ib->in", powers, inverse, powers)
    return powers @ curves.T, leverage, slopes / np.sqrt(size)[:, None]
