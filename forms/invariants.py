"""Isochoric invariants of the right Cauchy–Green tensor."""

import ufl
from ufl.core.expr import Expr


def right_cauchy_green(strain: Expr) -> Expr:
    """C = 2E + I, (3, 3), of the Green–Lagrange strain."""
    return 2 * strain + ufl.Identity(3)


def isochoric_tensor(strain: Expr) -> Expr:
    """C̄ = J^(−2/3) C, (3, 3), whose determinant is 1."""
    c = right_cauchy_green(strain)
    return ufl.det(c) ** (-1 / 3) * c


def isochoric(strain: Expr) -> tuple[Expr, Expr]:
    """Isochoric invariants of a strain, less 3.

    Args:
        strain: Green–Lagrange strain, (3, 3).

    Returns:
        Ī₁ − 3 and Ī₂ − 3 with Ī₁ = tr C̄ and Ī₂ = ½ (Ī₁² − tr C̄²) (Holzapfel, Nonlinear
        Solid Mechanics, 2000, eq. 6.109).

    Example:
        In simple shear by γ both are γ².

        >>> from dolfingrip.forms.evaluate import number
        >>> shear = ufl.as_matrix([[0, 0.25, 0], [0.25, 0.125, 0], [0, 0, 0]])  # γ = 1/2
        >>> [round(number(each), 9) for each in isochoric(shear)]
        [0.25, 0.25]
    """
    c = isochoric_tensor(strain)
    first = ufl.tr(c)
    second = (first**2 - ufl.inner(c, c)) / 2
    return first - 3, second - 3
