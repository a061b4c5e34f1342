"""Elementary functions of UFL expressions, of numbers and of jets alike.

A law of a material is said once. The solver gives it expressions, and a fit to coupons gives it
numbers or arrays.

>>> import ufl
>>> float(ln(exp(2.0))), sqrt(np.array([4.0, 9.0])).tolist(), isinstance(ln(ufl.as_ufl(2.0)), Expr)
(2.0, [2.0, 3.0], False)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import ufl
from ufl.core.expr import Expr

from dolfingrip.forms.jet import Jet

NEAREST: Final = 1e-6
"""Smallest distance from a limit, in numbers: a fit may try values where there is no state."""


def ln(x: Any) -> Any:
    """Return the natural logarithm.

    Args:
        x: expression, number, array or jet; above 0.
    """
    if isinstance(x, Jet):
        return x.through(ln(x.f), 1 / x.f, -1 / (x.f * x.f))
    return ufl.ln(x) if isinstance(x, Expr) else np.log(x)


def exp(x: Any) -> Any:
    """Return the exponential function.

    Args:
        x: expression, number, array or jet.

    >>> exp(Jet(0.0, 3.0, 0.0, 0.0, 0.0, 0.0)).xx == 9.0
    np.True_
    """
    if isinstance(x, Jet):
        value = exp(x.f)
        return x.through(value, value, value)
    return ufl.exp(x) if isinstance(x, Expr) else np.exp(x)


def sqrt(x: Any) -> Any:
    """Return the square root.

    Args:
        x: expression, number, array or jet; from 0 on, of a jet above 0.
    """
    if isinstance(x, Jet):
        root = sqrt(x.f)
        return x.through(root, 1 / (2 * root), -1 / (4 * root * root * root))
    return ufl.sqrt(x) if isinstance(x, Expr) else np.sqrt(x)


def remaining(x: Any) -> Any:
    """Return 1 − x, what is left to a limit at x = 1.

    Beyond the limit there is no state: an expression then has a logarithm of a negative number,
    which ends the step, and numbers are at :data:`NEAREST` to it, which a fit turns away from.

    Args:
        x: expression, number or array.
    """
    return 1 - x if isinstance(x, Expr) else np.maximum(1 - x, NEAREST)


def from_limit_on(x: Any, limit: float, near: Any, far: Callable[[Any], Any]) -> Any:
    """Return one value below a limit and another from there on.

    Args:
        x: expression, number or array.
        limit: of x.
        near: value where x is below the limit.
        far: function of x that gives the value elsewhere; it is called with no smaller x.

    >>> float(from_limit_on(4.0, 1.0, 0.0, sqrt)), float(from_limit_on(0.5, 1.0, 0.0, sqrt))
    (2.0, 0.0)
    """
    if isinstance(x, Expr):
        return ufl.conditional(ufl.lt(x, limit), near, far(ufl.max_value(x, limit)))
    return np.where(x < limit, near, far(np.maximum(x, limit)))
