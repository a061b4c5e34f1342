"""Numbers that coupon and drawing leave open, and laws of Ogden that follow the coupon."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from dolfingrip.experiments.material_fit import coupons, fit
from dolfingrip.experiments.material_fit.law import LAWS

COUPON = Path(__file__).resolve().parent.parent / "coupons" / "ecoflex30_uniaxial.csv"


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One way to settle what coupon and drawing leave open, but for two parameters.

    Attributes:
        exponent: of Ogden's term that governs biaxial tension.
        moduli_MPa: two of that term, which hold the fitted one between them or nearly so.
        film_N_per_mm: stiffness Et of the film, before moduli are scaled.
        width_mm: of the chambers; the source says 8, and in one place 4.
    """

    exponent: float
    moduli_MPa: tuple[float, float]
    film_N_per_mm: float = 3.0
    width_mm: float = 8.0


HYPOTHESES = (
    Hypothesis(-5.5, (6e-6, 8e-6)),
    Hypothesis(-7.0, (3.5e-7, 6e-7)),
    Hypothesis(-5.5, (6e-6, 8e-6), film_N_per_mm=10.0),
    Hypothesis(-5.5, (6e-6, 8e-6), width_mm=4.0),
)


def law(mu_MPa: float, alpha: float) -> tuple[list[float], list[float]]:
    """Moduli and exponents of three terms, one of them given, the others fitted to the coupon."""
    data, chosen = coupons.read(COUPON), LAWS["ogden-3"]
    measured, tolerance = fit.measured_MPa(data), fit.tolerances_MPa(data)

    def values(free: np.ndarray) -> np.ndarray:
        return np.array([free[0], mu_MPa, np.exp(free[1]), free[2], alpha, free[3]])

    def residuals(free: np.ndarray) -> np.ndarray:
        return np.asarray((fit.predicted_MPa(chosen, data, values(free)) - measured) / tolerance)

    found = least_squares(
        residuals,
        [0.0195, np.log(7e-6), 2.0, 7.0],
        x_scale=[0.01, 1, 1, 1],
        bounds=([0, -25, 0.3, 3], [1, 0, 4.5, 10]),
    )
    every = values(found.x)
    return [float(f"{v:.6g}") for v in every[:3]], [float(f"{v:.6g}") for v in every[3:]]


def changes(tried: Hypothesis, modulus_MPa: float, scale: float = 1.0) -> dict[str, object]:
    """Keys of the configuration with a hypothesis's values, all moduli scaled."""
    moduli, exponents = law(modulus_MPa, tried.exponent)
    return {
        "material.ogden_mu_MPa": [float(f"{scale * each:.6g}") for each in moduli],
        "material.ogden_alpha": exponents,
        "film.silk.Et_N_per_mm": float(f"{scale * tried.film_N_per_mm:.6g}"),
        "cast.chamber_width_mm": tried.width_mm,
    }
