"""Stress of a law whose volume may change, as a reference."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from dolfingrip.experiments.material_fit.law import EXPONENTS, Law, Mode, OfStretches

WIDEST_LOG_STRETCH = 3.0
"""Largest logarithm of a lateral stretch, from that at constant volume, in its search."""


def stress(
    law: Law, mode: Mode, stretch: np.ndarray, values: np.ndarray, bulk_MPa: float
) -> np.ndarray:
    """Nominal stress (MPa) along the stretch with K/2 (ln J)² added to the law's energy.

    The free directions' stretch is the root of their stress.
    """
    return np.array([_stress_MPa(law, mode, float(at), values, bulk_MPa) for at in stretch])


def _stress_MPa(law: Law, mode: Mode, stretch: float, values: np.ndarray, bulk_MPa: float) -> float:
    def kirchhoff(ln_lateral: float) -> np.ndarray:
        lateral = np.exp(ln_lateral)
        second = {"uniaxial": lateral, "planar": 1.0, "equibiaxial": stretch}[mode]
        logarithms = np.log([stretch, second, lateral])
        ln_j = logarithms.sum()
        energy = law.energy(values, OfStretches(logarithms - ln_j / 3))
        tau = np.array([energy.x, energy.y, 0.0])
        return np.asarray(tau - tau.mean() + bulk_MPa * ln_j)

    middle = float(EXPONENTS[mode][2] * np.log(stretch))
    ends = middle - WIDEST_LOG_STRETCH, middle + WIDEST_LOG_STRETCH
    root = brentq(lambda x: float(kirchhoff(x)[2]), *ends, xtol=1e-14, rtol=1e-14)
    return float(kirchhoff(root)[0] / stretch)
