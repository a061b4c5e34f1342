"""Remainders of Taylor series, by which a derivative is verified."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.tangent import Tangent


def rates(
    function: Callable[[float], np.ndarray | float],
    slope: np.ndarray | float,
    longest: float,
    halvings: int = 6,
) -> np.ndarray:
    """Observed orders of ‖f(ε) − f(0) − ε f'(0)‖ between successive halvings of ε.

    Args:
        function: f along a direction.
        slope: the derivative f'(0) under test.
        longest: the first ε.
        halvings: their number.

    Returns:
        Orders: 2 for the right derivative of a curved f, 1 for a wrong one.
    """
    base = function(0.0)
    size = [
        np.linalg.norm(function(e) - base - e * slope)
        for e in longest * 0.5 ** np.arange(halvings + 1)
    ]
    found = np.log2(np.array(size[:-1]) / np.array(size[1:]))
    print("remainders", size, "orders", found)
    return np.asarray(found)


def check_derivatives(
    model: Model, tangent: Tangent, direction: np.ndarray, longest: float
) -> None:
    """The gradient is the energy's derivative, the tangent the gradient's; of global ones, too.

    Args:
        model: in the state to look at, and again after.
        tangent: assembled there.
        direction: owned values, 0 where supports hold.
        longest: see :func:`rates`.
    """
    start = model.unknowns.owned()
    w, product = (model.unknowns.create_vector() for _ in range(2))
    w.array[:] = direction
    tangent.matrix.mult(w, product)
    slope = np.array(product.array)

    def energy(step: float) -> float:
        model.unknowns.set_owned(start + step * direction)
        return model.energy()

    def gradient(step: float) -> np.ndarray:
        model.unknowns.set_owned(start + step * direction)
        return model.gradient()

    assert rates(energy, float(gradient(0.0) @ direction), longest).min() > 1.9
    assert rates(gradient, slope, longest).min() > 1.9
    rows = model.unknowns.global_rows(np.arange(len(start)))
    assert rates(lambda e: gradient(e)[rows], slope[rows], longest).min() > 1.9
    model.unknowns.set_owned(start)
