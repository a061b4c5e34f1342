"""Exact evidence of a cause whose change of the readings is quadratic in its strength.

The exponent of the integrand, a b·r + a² c·r − |a b + a² c|²/2 − (a − m)²/(2 s²), is a polynomial
of degree four, so its maxima are roots of a cubic. The integral is taken by Gauss–Legendre rules on
panels that are graded towards them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import Polynomial
from scipy.special import log_ndtr, logsumexp

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector, unit
from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.evidence import INTERVAL, Amplitude
from dolfingrip.diagnosis.inference.screen import Score, Screen

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
REACH = 12.0
"""Standard deviations of the prior within which strengths are looked for."""
GRADING = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Ends of panels on both sides of a maximum, in its widths."""


@dataclass(frozen=True, eq=False)
class CurvedShape(Shape):
    """A change that passes through 0, through ``change`` at strength 1, and a second one.

    Attributes:
        second: another strength (neither 0 nor 1) and the change there, shape (n,).
    """

    second: tuple[float, Vector] = (0.0, np.zeros(0))

    def polynomial(self) -> tuple[Vector, Vector]:
        """b and c of change(a) = a b + a² c, shape (n,) each."""
        strength, change = self.second
        curved = (change - strength * self.change) / (strength * (strength - 1))
        return self.change - curved, np.asarray(curved)


class CurvedScreen(Screen):
    """A screen of which some shapes are curves; pairs take these by their secants."""

    def __init__(self, candidates: Sequence[Candidate], covariance: Covariance) -> None:
        """Whiten."""
        super().__init__(candidates, covariance)
        self._curved = {
            number: tuple(covariance.whiten(part) for part in shape.polynomial())
            for number, shape in enumerate(self.shapes)
            if isinstance(shape, CurvedShape)
        }

    def shape_evidence(self, whitened: Matrix) -> Matrix:
        """See :class:`Screen`."""
        logs = super().shape_evidence(whitened)
        for number in self._curved:
            for sample in range(whitened.shape[1]):
                logs[number, sample] = self._integral(number, whitened[:, sample])[0]
        return logs

    def draw_change(self, i: int, rng: np.random.Generator) -> Vector:
        """See :class:`Screen`."""
        number, strength = self.candidates[i].draw(rng)
        shape = int(np.flatnonzero(self.owner == i)[number])
        straight, curved = self._curved.get(shape, (self.columns[:, shape], 0.0))
        return np.asarray(strength * straight + strength**2 * curved)

    def scores(self, whitened: Vector) -> list[Score]:
        """See :class:`Screen`."""
        return [self._along_curve(i, s, whitened) for i, s in enumerate(super().scores(whitened))]

    def _along_curve(self, i: int, score: Score, whitened: Vector) -> Score:
        """Normal about the most probable strength, along the curve's tangent there."""
        number = int(np.flatnonzero(self.owner == i)[score.shape])
        if number not in self._curved:
            return score
        candidate = self.candidates[i]
        straight, curved = self._curved[number]
        peak = self._integral(number, whitened)[1]
        change = peak * straight + peak**2 * curved
        slope = straight + 2 * peak * curved
        std = float((slope @ slope + 1 / candidate.spread**2) ** -0.5)
        low, high = peak - INTERVAL * std, peak + INTERVAL * std
        fitted = Amplitude(peak, std, max(low, 0.0) if candidate.one_sided else low, high)
        length = float(np.linalg.norm(change))
        return replace(score, amplitude=fitted, strength_sigma=length, direction=unit(change))

    def _integral(self, number: int, whitened: Vector) -> tuple[float, float]:
        candidate = self.candidates[self.owner[number]]
        return log_bayes_factor(
            *self._curved[number], whitened, candidate.mean, candidate.spread, candidate.one_sided
        )


def log_bayes_factor(
    straight: Vector,
    curved: Vector,
    residual: Vector,
    mean: float,
    spread: float,
    one_sided: bool,
) -> tuple[float, float]:
    """ln BF against no effect, and the most probable strength.

    Args:
        straight, curved: b and c of the whitened change a b + a² c, shape (n,) each.
        residual: whitened, shape (n,).
        mean, spread: of the strength's normal prior.
        one_sided: whether only strengths above 0 are possible.
    """
    likelihood = Polynomial(
        [
            0.0,
            straight @ residual,
            curved @ residual - 0.5 * straight @ straight,
            -straight @ curved,
            -0.5 * curved @ curved,
        ]
    )
    exponent = likelihood - 0.5 * Polynomial([-mean / spread, 1 / spread]) ** 2
    low = 0.0 if one_sided else mean - REACH * spread
    high = max(mean, 0.0) + REACH * spread
    peaks = _maxima(exponent, low, high)
    panels = _panels(exponent, peaks, low, high)
    half = 0.5 * np.diff(panels)[:, None]
    points = (0.5 * (panels[:-1] + panels[1:]))[:, None] + half * NODES
    total = float(logsumexp(exponent(points), b=half * WEIGHTS))
    norm = np.log(spread) + 0.5 * np.log(2 * np.pi)
    norm += float(log_ndtr(mean / spread)) if one_sided else 0.0
    return total - norm, max(peaks, key=exponent)


def _maxima(exponent: Polynomial, low: float, high: float) -> list[float]:
    """Places of local maxima within [low, high]; its ends are among them."""
    roots = exponent.deriv().roots()
    real = roots[np.abs(roots.imag) < 1e-6 * (1 + np.abs(roots.real))].real
    return [low, high, *(float(x) for x in real if low < x < high)]


def _panels(exponent: Polynomial, peaks: list[float], low: float, high: float) -> Vector:
    slope, curvature = exponent.deriv(), exponent.deriv(2)
    ends = list(np.linspace(low, high, 25))
    for peak in peaks:
        rate = max(np.sqrt(max(-curvature(peak), 0.0)), abs(slope(peak)), 1 / (high - low))
        ends += [peak + side * step / rate for step in GRADING for side in (-1, 1)]
        ends.append(peak)
    return np.unique(np.clip(ends, low, high))
