"""A body's free swing after its last push: frequency, decay and spectrum of a reading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import curve_fit
from scipy.signal import detrend, get_window

FEWEST_SWINGS: Final = 1.5
"""Swings that a record must have, so that frequency and decay are told apart."""

MOST_SWINGS: Final = 5
"""Swings to which a decay is fitted; later ones are lost in noise, and large ones fade faster."""

FEWEST_READINGS: Final = 6
"""Readings of a swing below which its largest values are missed."""

MOST_LEFT: Final = 0.2
"""Part of the swings' variance that the fit may leave; more is another motion."""

FINER: Final = 4
"""Frequencies of a spectrum for each one that a record tells apart, so that its line is smooth."""


@dataclass(frozen=True, slots=True)
class RingDown:
    """A reading that swings at one frequency and fades, about a place of rest that may creep.

    y(t) = rest(t) + size exp(−rate (t − start)) cos(2π frequency (t − start) + phase)

    Attributes:
        start_s, end_s: times between which it was fitted (s).
        rest: the place of rest by the time (s), a straight line in the reading's unit.
        size: in the reading's unit.
        rate_per_s: of decay (1/s).
        frequency_Hz: of the damped swing (Hz).
        phase: at the start (rad).
    """

    start_s: float
    end_s: float
    rest: Polynomial
    size: float
    rate_per_s: float
    frequency_Hz: float
    phase: float

    @property
    def ratio(self) -> float:
        """A swing by that one period before."""
        return float(np.exp(-self.rate_per_s / self.frequency_Hz))

    @property
    def sentence(self) -> str:
        """Frequency and decay in words."""
        return f"{self.frequency_Hz:.3g} Hz, each swing {self.ratio:.2f} of the one before"

    def envelope(self, time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The lines between which the reading swings.

        Args:
            time_s: shape (n,), times (s).

        Returns:
            The lower and the upper one, shape (n,) each, in the reading's unit.
        """
        half = abs(self.size) * np.exp(-self.rate_per_s * (time_s - self.start_s))
        return self.rest(time_s) - half, self.rest(time_s) + half


def fit(time_s: np.ndarray, control: np.ndarray, reading: np.ndarray) -> RingDown | None:
    """Fit a fading swing to what follows the last change of the control, by least squares.

    Args:
        time_s: shape (n,), times that rise (s).
        control: what drives the body, such as its pressure; it rings down from its last change on.
        reading: in any unit.

    Returns:
        The swing, from its largest reading on the other side of its place of rest; None where the
        record has too few swings, or too few readings of each, or moves otherwise.
    """
    changes = np.flatnonzero(np.abs(np.diff(control)) > 1e-6 * np.ptp(control))
    held = slice(int(changes[-1]) + 1 if len(changes) else 0, None)
    t, y = time_s[held], reading[held]
    if len(t) < FEWEST_SWINGS * FEWEST_READINGS:
        return None
    off = y - np.median(y[-(len(y) // 3) :])
    crossings = np.flatnonzero(np.diff(np.sign(off)))
    if not len(crossings):
        return None
    first = int(crossings[0]) + 1
    start = first + int(np.argmax(np.abs(off[first:])))
    t, y, off = t[start:], y[start:], off[start:]
    if len(t) < FEWEST_SWINGS * FEWEST_READINGS:
        return None
    frequencies, sizes = spectrum(t, y)
    swinging = frequencies >= FEWEST_SWINGS / (t[-1] - t[0])
    about = float(frequencies[np.argmax(sizes * swinging)])
    fitted = t <= t[0] + MOST_SWINGS / about
    since, y = t[fitted] - t[0], y[fitted]

    def model(at: np.ndarray, *p: float) -> np.ndarray:
        level, creep, size, rate, frequency, phase = p
        swing = np.exp(-rate * at) * np.cos(2 * np.pi * frequency * at + phase)
        return level + creep * at + size * swing

    begin = [y[0] - off[0], 0.0, off[0], about / 3, about, 0.0]
    try:
        level, creep, *swing = map(float, curve_fit(model, since, y, begin)[0])
    except RuntimeError:  # it does not converge
        return None
    line = Polynomial([level - creep * t[0], creep])
    left = np.var(y - model(since, level, creep, *swing)) / np.var(y - line(t[fitted]))
    ring_down = RingDown(float(t[0]), float(t[fitted][-1]), line, *swing)
    swings = ring_down.frequency_Hz * since[-1]
    unclear = left > MOST_LEFT or swings < FEWEST_SWINGS
    return None if unclear or len(since) < FEWEST_READINGS * swings else ring_down


def spectrum(time_s: np.ndarray, reading: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sizes of the swings in a record by frequency, by a Hann window.

    Args:
        time_s: shape (n,), times that rise (s); readings at unequal times are interpolated.
        reading: in any unit; its mean and slope are left out.

    Returns:
        Frequencies (Hz) from 0 to half the rate, and sizes in the reading's unit: a steady swing
        has its amplitude.
    """
    even = np.linspace(time_s[0], time_s[-1], len(time_s))
    window = get_window("hann", len(even), fftbins=False)
    values = window * detrend(np.interp(even, time_s, reading))
    padded = FINER * len(even)
    sizes = 2 * np.abs(np.fft.rfft(values, padded)) / window.sum()
    return np.fft.rfftfreq(padded, even[1] - even[0]), sizes
