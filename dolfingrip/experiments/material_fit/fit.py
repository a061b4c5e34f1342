"""A law fitted to coupons by least squares, with the intervals of its values.

The fit is written as a configuration that every command reads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import tomlkit
from scipy.optimize import OptimizeResult, least_squares, nnls

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.experiments.material_fit.coupons import CouponSeries, reach
from dolfingrip.experiments.material_fit.law import LAWS, Law, Mode, stress
from dolfingrip.files import whole
from dolfingrip.sections.material import OF_RUBBER

Values = np.ndarray


WITHIN: Final = 1.645
"""Half width of a 90 % interval of a normal distribution, in standard deviations."""

TOLERANCE: Final = 0.02
"""Accuracy that is asked of a law, as a part of a reading's stress; it is added to the noise, so
that small stresses weigh as much as large ones."""

LOOSE: Final = 0.2
"""A prediction is not determined if its half width is a larger part of it than this."""

EQUAL: Final = 0.1
"""Fits whose relative scatter is larger than the smallest by no more than this part of it are as
good."""

NOTHING: Final = 0.01
"""Part of the scatter by which a term improves a law at least, or it is left out."""

FINEST: Final = 0.001
"""Fits whose relative scatter is below this are equally good, as no coupon is measured better."""

MISFIT: Final = 0.2
"""Relative rms above which a law is no description of the readings, and is not written."""

NEGLIGIBLE: Final = 1e-3
"""Part of the largest modulus from which others start that are best at 0."""

STARTS: Final = 8
"""Starts of a fit that has more; those are taken whose best moduli leave the least misfit."""

FREE: Final = 100.0
"""A value is called free if the half width of its interval is larger by this factor."""

MIDDLE_STRETCH: Final = 1.5
"""Stretch at which other modes are predicted, if the coupons go so far."""

LOOKED_AT: Final = 8.0
"""Stretch up to which instabilities and a balloon's limit points are sought; twice the largest
measured stretch where coupons went further."""

DIGITS: Final = 6
"""Number of digits of a value that is written; its interval is never so narrow."""


@dataclass(frozen=True, slots=True)
class LawFit:
    """The values of a law that fit best.

    Attributes:
        law: the law.
        values: values of its parameters.
        covariance: covariance of the values; correlated residuals count as fewer readings.
        rms_MPa: root mean square of the residuals.
        relative_rms: root mean square of the residuals relative to the readings, for readings above
            a tenth of the largest.
        misfit: sum of squares of the residuals relative to their tolerances.
        correlation: correlation of successive residuals, the mean over the specimens.
        count: number of readings.
        effective: number of independent readings.
    """

    law: Law
    values: Values
    covariance: np.ndarray
    rms_MPa: float
    relative_rms: float
    misfit: float
    correlation: float
    count: int
    effective: float

    @property
    def half_width(self) -> Values:
        """Half width of the 90 % interval of each value."""
        return np.asarray(WITHIN * np.sqrt(np.diag(self.covariance)))

    @property
    def scatter(self) -> float:
        """Relative scatter of readings about the law, estimated without bias.

        Each constant takes one degree of freedom from the residuals.
        """
        return self.relative_rms * (self.count / (self.count - len(self.values))) ** 0.5

    @property
    def criterion(self) -> float:
        """Bayesian information criterion (Schwarz), χ² + k ln n; the smallest is the best."""
        return self.misfit + len(self.values) * float(np.log(self.count))

    def band(self, mode: Mode, stretch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nominal stress and the half width of its 90 % interval to first order (MPa), (n,)."""
        middle = stress(self.law, mode, stretch, self.values)
        slopes = jacobian(self.law, self.values, lambda v: stress(self.law, mode, stretch, v))
        variance = np.einsum("ni,ij,nj->n", slopes, self.covariance, slopes)
        return middle, WITHIN * np.sqrt(np.maximum(variance, 0.0))


def fit(law: Law, data: Sequence[CouponSeries]) -> LawFit:
    """Fit a law from several starts and return the best fit.

    If a law misses the curve, successive residuals are correlated. With a correlation ρ, n readings
    tell as much as n (1 − ρ)/(1 + ρ) independent ones.

    Args:
        law: law to fit.
        data: series with more readings than the law has parameters.
    """
    measured, tolerance = measured_MPa(data), tolerances_MPa(data)

    def residuals(values: Values) -> np.ndarray:
        return np.asarray((predicted_MPa(law, data, values) - measured) / tolerance)

    scale = shear_MPa(data)
    starts = [np.array(start) for start in law.fittable.starts(scale)]
    if len(starts) > STARTS:
        starts = _likeliest(law, data, starts)
    solutions = [_solved(law, residuals, start, scale) for start in starts]
    values = np.asarray(min(solutions, key=lambda solution: float(solution.cost)).x)
    left = residuals(values)
    correlation, effective = _correlation(left, data)
    variance = residual_variance(float(left @ left), len(values), effective, data)
    slopes = jacobian(law, values, residuals)
    left_MPa = left * tolerance
    large = np.abs(measured) > 0.1 * np.abs(measured).max()
    return LawFit(
        law,
        values,
        _covariance(slopes, values, scale) * variance * len(left) / effective,
        float(np.sqrt(np.mean(left_MPa**2))),
        float(np.sqrt(np.mean((left_MPa[large] / measured[large]) ** 2))),
        float(left @ left),
        correlation,
        len(left),
        effective,
    )


def of_use(fitted: LawFit, data: Sequence[CouponSeries]) -> LawFit:
    """Return the fit of the law without a term that improves nothing, else the fit itself.

    Args:
        fitted: fit of a law.
        data: series that it was fitted to.
    """
    law = LAWS.get(fitted.law.fittable.fewer)
    if law is None:
        return fitted
    less = of_use(fit(law, data), data)
    return less if less.scatter <= max((1 + NOTHING) * fitted.scatter, FINEST) else fitted


def jacobian(law: Law, values: Values, function: Callable[[Values], np.ndarray]) -> np.ndarray:
    """Derivatives of a function of the values, (n, values), by differences within the bounds."""
    low, high = law.fittable.low, law.fittable.high
    columns = []
    for i, value in enumerate(values):
        h = 1e-6 * (abs(value) or float(np.abs(values).max()) or 1.0)
        after, before = values.copy(), values.copy()
        after[i] = min(value + h, high[i]) if high else value + h
        before[i] = max(value - h, low[i]) if low else value - h
        columns.append((function(after) - function(before)) / (after[i] - before[i]))
    return np.stack(columns, axis=1)


def measured_MPa(data: Sequence[CouponSeries]) -> np.ndarray:
    """Nominal stresses of all series, one after another."""
    return np.concatenate([series.stress_MPa for series in data])


def predicted_MPa(law: Law, data: Sequence[CouponSeries], values: Values) -> np.ndarray:
    """Nominal stresses of the law at the stretches of the data."""
    return np.concatenate([stress(law, series.mode, series.stretch, values) for series in data])


def tolerances_MPa(data: Sequence[CouponSeries]) -> np.ndarray:
    """Tolerances (MPa) that residuals are divided by: noise, and a part of the reading."""
    measured = measured_MPa(data)
    least = 0.1 * TOLERANCE * float(np.abs(measured).max())
    return np.hypot(np.maximum(_noise_MPa(data), least), TOLERANCE * measured)


def residual_variance(
    misfit: float, free: int, effective: float, data: Sequence[CouponSeries]
) -> float:
    """Variance of the residuals relative to their tolerances; it is at least that of the noise.

    Args:
        misfit: sum of their squares.
        free: number of values that were fitted.
        effective: number of independent readings.
        data: data that they are residuals of.
    """
    tolerance = tolerances_MPa(data)
    spare = max(effective - free, 1.0)
    noise = float(np.mean((_noise_MPa(data) / tolerance) ** 2))
    return max(misfit / len(tolerance) * effective / spare, noise)


def shear_MPa(data: Sequence[CouponSeries]) -> float:
    """Neo-Hooke's shear modulus by linear least squares."""
    shape = predicted_MPa(LAWS["neo-hooke"], data, np.array([1.0]))
    return max(float(shape @ measured_MPa(data) / (shape @ shape)), 1e-9)


def _noise_MPa(data: Sequence[CouponSeries]) -> np.ndarray:
    return np.concatenate([np.full(len(s.stretch), s.noise_MPa or 0.0) for s in data])


def _likeliest(law: Law, data: Sequence[CouponSeries], starts: Sequence[Values]) -> list[Values]:
    """The starts with the least misfit, each with its best moduli, which the law is linear in."""
    moduli = [i for i, key in enumerate(law.keys) if "MPa" in key]
    tolerance, ranked = tolerances_MPa(data), []
    for start in starts:
        scaled = start.copy()
        scaled[moduli] = 0.0
        units = scaled + np.eye(len(start))[moduli]
        basis = np.stack([predicted_MPa(law, data, unit) / tolerance for unit in units], axis=1)
        best, left = nnls(basis, measured_MPa(data) / tolerance)
        scaled[moduli] = np.maximum(best, NEGLIGIBLE * best.max())
        ranked.append((float(left), scaled))
    return [start for _, start in sorted(ranked, key=lambda pair: pair[0])[:STARTS]]


def _solved(
    law: Law, residuals: Callable[[Values], np.ndarray], start: Values, scale: float
) -> OptimizeResult:
    size = [scale if "MPa" in key else 1.0 for key in law.keys]
    return least_squares(
        residuals,
        start,
        bounds=law.fittable.bounds([float(entry) for entry in start]),
        x_scale=size,
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
        max_nfev=400,
    )


def _covariance(slopes: np.ndarray, values: Values, scale: float) -> np.ndarray:
    """Inverse of the information; a direction without information is very wide, not infinite."""
    size = np.maximum(np.abs(values), 1e-6 * scale)
    _, singular, ways = np.linalg.svd(slopes * size, full_matrices=False)
    singular = np.maximum(singular, 1e-9 * singular.max())
    return np.asarray((ways.T / singular**2) @ ways * np.outer(size, size))


def _correlation(left: np.ndarray, data: Sequence[CouponSeries]) -> tuple[float, float]:
    """Correlation of successive residuals, and the number of independent residuals."""
    parts = np.split(left, np.cumsum([len(series.stretch) for series in data])[:-1])
    correlations, effective = [], 0.0
    for part in parts:
        size = float(part @ part)
        rho = float(part[1:] @ part[:-1]) / size if size else 0.0
        correlations.append(min(max(rho, 0.0), 0.99))
        effective += len(part) * (1 - correlations[-1]) / (1 + correlations[-1])
    return float(np.mean(correlations)), max(effective, 2.0)


def allowed(fit: LawFit) -> bool:
    """Return whether a configuration may hold the values, whose shear modulus must be above 0.

    Args:
        fit: the fitted law.
    """
    try:
        config.from_dict(fit.law.tables(fit.values))
    except ConfigError:
        return False
    return True


def write(fit: LawFit, data: Sequence[CouponSeries], file: Path) -> None:
    """Write the tables of the fitted law; comments tell the data that it was fitted to.

    Args:
        fit: the fitted law.
        data: the coupons' readings.
        file: TOML to write.

    Raises:
        WriteError: one line.
    """
    document = tomlkit.document()
    names = ", ".join(dict.fromkeys(series.name.partition(" ")[0] for series in data))
    modes = ", ".join(dict.fromkeys(series.mode for series in data))
    for line in (
        f"{fit.law.title}, fitted to {names}: {modes} tension, {fit.count} readings",
        reach(data),
        f"rms {fit.rms_MPa:.3g} MPa, {100 * fit.relative_rms:.2g} % of the readings",
        "90 % intervals: "
        + ", ".join(
            f"{key.rpartition('.')[2]} ± {half:.2g}"
            for key, half in zip(fit.law.keys, fit.half_width, strict=True)
        ),
        'Fitted at constant volume. Tetrahedra of 10 nodes lock: take solver.element = "P2-P1".',
    ):
        document.add(tomlkit.comment(line))
    values = [float(f"{value:.{DIGITS}g}") for value in fit.values]
    for name, table in fit.law.tables(values).items():
        document.add(name, table | {"nu": OF_RUBBER})
    whole.write(file, tomlkit.dumps(document))
