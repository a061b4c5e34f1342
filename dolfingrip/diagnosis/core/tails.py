"""The model's own numbers may be far from what was told: a prior with tails.

A number is off by sinh(t ζ)/t standard deviations for a standard normal ζ, where t is
:attr:`Policy.tail`.
"""

from __future__ import annotations

import numpy as np

from dolfingrip.diagnosis.policy import POLICY


def off(zeta: float | np.ndarray) -> np.ndarray:
    """Standard deviations that a number is off by, of the shape of ζ."""
    return np.asarray(np.sinh(POLICY.tail * np.asarray(zeta)) / POLICY.tail)


def rate(zeta: float | np.ndarray) -> np.ndarray:
    """Derivative of :func:`off` by ζ."""
    return np.asarray(np.cosh(POLICY.tail * np.asarray(zeta)))


def zeta_of(off: float | np.ndarray) -> np.ndarray:
    """ζ of so many standard deviations."""
    return np.asarray(np.arcsinh(POLICY.tail * np.asarray(off)) / POLICY.tail)
