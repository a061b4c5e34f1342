"""Remainders of Taylor series, by which a derivative is verified."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

STEPS = 0.5 ** np.arange(7)
"""Fractions of a direction; each halves the one before."""


def rates(
    function: Callable[[float], np.ndarray | float], slope: np.ndarray | float, longest: float
) -> np.ndarray:
    """Observed orders of ‖f(ε) − f(0) − ε f'(0)‖ between successive halvings of ε.

    Args:
        function: f along a direction.
        slope: the derivative f'(0) under test.
        longest: the first ε.

    Returns:
        Orders: 2 for the right derivative of a curved f, 1 for a wrong one.
    """
    base = function(0.0)
    size = [np.linalg.norm(function(e) - base - e * slope) for e in longest * STEPS]
    found = np.log2(np.array(size[:-1]) / np.array(size[1:]))
    print("remainders", size, "orders", found)
    return np.asarray(found)
