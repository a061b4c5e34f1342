"""Finite-strain kinematics shared by the energies."""

import ufl
from ufl.core.expr import Expr


def deformation_gradient(u: Expr) -> Expr:
    """Deformation gradient F = I + ∇u of a displacement.

    Args:
        u: displacement (mm).

    Returns:
        F, (3, 3).
    """
    return ufl.Identity(3) + ufl.grad(u)


def green_lagrange(u: Expr) -> Expr:
    """Green–Lagrange strain E = ½(∇u + ∇uᵀ + ∇uᵀ∇u) of a displacement.

    It is not written as (FᵀF − I)/2, because that difference loses digits at small strain.

    Args:
        u: displacement (mm).

    Returns:
        E, (3, 3).

    Example:
        Along a stretch λ it is ½ (λ² − 1), which is 3/2 at λ = 2.

        >>> from dolfingrip.forms.evaluate import displacement, number
        >>> number(green_lagrange(displacement([[1, 0, 0], [0, 1, 0], [0, 0, 2]]))[2, 2])
        1.5
    """
    h = ufl.grad(u)
    return (h + h.T + h.T * h) / 2


def strain_variation(u: Expr, v: Expr) -> Expr:
    """Variation of the Green–Lagrange strain along a direction.

    Args:
        u: displacement (mm).
        v: direction (mm).

    Returns:
        sym(Fᵀ∇v), (3, 3).
    """
    return ufl.sym(deformation_gradient(u).T * ufl.grad(v))


def geometric_variation(v: Expr, w: Expr) -> Expr:
    """Second variation of the Green–Lagrange strain along two directions.

    Args:
        v: one direction (mm).
        w: the other direction (mm).

    Returns:
        sym(∇vᵀ∇w), (3, 3).
    """
    return ufl.sym(ufl.grad(v).T * ufl.grad(w))


def current_area_vector(u: Expr, normal: Expr) -> Expr:
    """Nanson's formula: n da = cof(F) N dA, (3,), per reference area.

    Args:
        u: displacement (mm).
        normal: N, the unit normal of the undeformed surface.
    """
    f = deformation_gradient(u)
    return ufl.cofac(f) * normal
