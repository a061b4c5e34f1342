"""Evidence and intervals of a fit that is nonlinear in its parameters (Laplace's method).

Parameters are given by numbers ζ that are standard normal before measuring: mean + spread ζ,
or its log-normal counterpart of the same mean and spread. At the minimum of ½|w(ζ)|² + ½|ζ|², w the
whitened residual and J = ∂w/∂ζ (Gauss–Newton), the evidence is

    ln Z = −½|w|² − ½|ζ|² − ½ ln |1 + JᵀJ| − ½ ln |C| − (n/2) ln 2π

(MacKay 2003, Information Theory, Inference, and Learning Algorithms, chapter 27).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.evidence import INTERVAL
from dolfingrip.extensions.effect import Prior

MARGIN = 1e-3
"""Distance of the start from bounds, in ζ."""
XTOL, FTOL = 1e-5, 1e-4
"""Where a fit stops: the evidence is known to a hundredth where the fit is good."""


@dataclass(frozen=True)
class Estimate:
    """A parameter after measuring, in its own unit.

    Attributes:
        value: most probable ζ's value.
        low, high: ends of the central 90 %.
        std_by_prior: standard deviation of ζ, 1 where the readings told nothing.
    """

    value: float
    low: float
    high: float
    std_by_prior: float


@dataclass(frozen=True, eq=False)
class LaplaceFit:
    """A fit.

    Attributes:
        log_evidence: ln Z.
        estimates: of each parameter.
        correlation: of the ζ, shape (p, p).
        zeta: shape (p,).
        chi_squared: |w|² at the minimum.
        evaluations: of the residual, those for a Jacobian by differences included.
    """

    log_evidence: float
    estimates: tuple[Estimate, ...]
    correlation: Matrix
    zeta: Vector
    chi_squared: float
    evaluations: int = 0


def to_value(prior: Prior, zeta: float) -> float:
    """A parameter's value from its standard normal number."""
    if not prior.positive:
        return prior.mean + prior.spread * zeta
    variance = math.log1p((prior.spread / prior.mean) ** 2)
    return prior.mean * math.exp(math.sqrt(variance) * zeta - variance / 2)


def to_values(priors: Iterable[Prior], zeta: Iterable[float]) -> list[float]:
    """Values of parameters."""
    return [to_value(prior, float(z)) for prior, z in zip(priors, zeta, strict=True)]


def to_zeta(prior: Prior, value: float) -> float:
    """The inverse of :func:`to_value`.

    Raises:
        ValueError: where the parameter is positive and the value is not.
    """
    if not prior.positive:
        return (value - prior.mean) / prior.spread
    if value <= 0:
        raise ValueError(f"value = {value}: allowed: above 0")
    variance = math.log1p((prior.spread / prior.mean) ** 2)
    return (math.log(value / prior.mean) + variance / 2) / math.sqrt(variance)


def slope(prior: Prior, zeta: float) -> float:
    """Derivative of the value by ζ."""
    if not prior.positive:
        return prior.spread
    return math.sqrt(math.log1p((prior.spread / prior.mean) ** 2)) * to_value(prior, zeta)


def laplace(
    whitened: Vector,
    jacobian: Matrix,
    zeta: Vector,
    priors: Sequence[Prior],
    logdet: float,
    evaluations: int = 0,
) -> LaplaceFit:
    """Evidence and intervals at a minimum that was found.

    Args:
        whitened: residual w, shape (n,).
        jacobian: of w by ζ, shape (n, p); that by a value is to be multiplied by :func:`slope`.
        zeta: at the minimum, shape (p,).
        priors: of the parameters.
        logdet: ln |C|.
        evaluations: what it took to find it.
    """
    information = np.eye(len(zeta)) + jacobian.T @ jacobian
    covariance = np.linalg.inv(information)
    std = np.sqrt(np.diag(covariance))
    chi_squared = float(whitened @ whitened)
    log_evidence = -0.5 * (
        chi_squared
        + zeta @ zeta
        + np.linalg.slogdet(information)[1]
        + logdet
        + len(whitened) * math.log(2 * math.pi)
    )
    estimates = tuple(
        Estimate(
            value=to_value(prior, z),
            low=to_value(prior, z - INTERVAL * s),
            high=to_value(prior, z + INTERVAL * s),
            std_by_prior=float(s),
        )
        for prior, z, s in zip(priors, zeta, std, strict=True)
    )
    return LaplaceFit(
        log_evidence=float(log_evidence),
        estimates=estimates,
        correlation=covariance / np.outer(std, std),
        zeta=np.asarray(zeta, dtype=float),
        chi_squared=chi_squared,
        evaluations=evaluations,
    )


def fit(
    residual: Callable[[Sequence[float]], Vector],
    priors: Sequence[Prior],
    logdet: float,
    start: Sequence[float] | None = None,
    jacobian: Callable[[Sequence[float]], Matrix] | None = None,
    step: float = 1e-3,
    most_evaluations: int | None = None,
    bounds: Sequence[tuple[float, float]] | None = None,
    ftol: float = FTOL,
) -> LaplaceFit:
    """Find the most probable parameters, and the evidence there.

    Args:
        residual: whitened residual, shape (n,), of the parameters' values.
        priors: of the parameters.
        logdet: ln |C|.
        start: values to start from; the priors' medians where None.
        jacobian: of the residual by the values, shape (n, p); by forward differences where None.
        step: of these differences, in ζ: large enough for the residual's own tolerance.
        most_evaluations: of the residual, those for differences left out; scipy's limit where None.
        bounds: of the values, lowest and highest; none where None.
        ftol: relative change of the sum of squares below which it ends.
    """
    count = 0

    def stacked(zeta: Vector) -> Vector:
        nonlocal count
        count += 1
        return np.concatenate([residual(to_values(priors, zeta)), zeta])

    def slopes(zeta: Vector) -> Matrix:
        assert jacobian is not None
        factors = np.array([slope(p, float(z)) for p, z in zip(priors, zeta, strict=True)])
        return np.vstack([jacobian(to_values(priors, zeta)) * factors, np.eye(len(zeta))])

    def differences(zeta: Vector) -> Matrix:
        here = stacked(zeta)
        columns = [(stacked(zeta + step * unit) - here) / step for unit in np.eye(len(zeta))]
        return np.column_stack(columns)

    first = (
        np.zeros(len(priors))
        if start is None
        else np.array([to_zeta(p, value) for p, value in zip(priors, start, strict=True)])
    )
    low, high = zeta_bounds(priors, bounds or [(-math.inf, math.inf)] * len(priors))
    found = least_squares(
        stacked,
        np.clip(first, low + MARGIN, high - MARGIN),
        jac=slopes if jacobian is not None else differences,
        bounds=(low, high),
        max_nfev=most_evaluations,
        xtol=XTOL,
        ftol=ftol,
    )
    n = len(found.fun) - len(priors)
    return laplace(found.fun[:n], found.jac[:n], found.x, priors, logdet, count)


def zeta_bounds(
    priors: Sequence[Prior], bounds: Sequence[tuple[float, float]]
) -> tuple[Vector, Vector]:
    """Bounds of the values as bounds of ζ."""
    low, high = [], []
    for prior, (least, most) in zip(priors, bounds, strict=True):
        low.append(-math.inf if prior.positive and least <= 0 else to_zeta(prior, least))
        high.append(to_zeta(prior, most))
    return np.array(low), np.array(high)
