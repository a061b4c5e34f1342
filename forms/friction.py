"""Coulomb friction, smooth where nothing slips."""

import ufl
from ufl.core.expr import Expr


def energy(slip: Expr, pressure: Expr, coefficient: Expr, width: Expr) -> Expr:
    """Incremental potential of a load step per area (mJ/mm²), zero at no slip.

    ψ = μ p (√(|s|² + ε²) − ε)

    Its traction μ p s/√(|s|² + ε²) is Coulomb's where the slip s is long against ε, and a spring's
    where it is short. It is a potential because the pressure p is held during the step. Its
    dissipation, traction times slip, is never negative.

    Args:
        slip: tangential displacement s since the step's start, (3,), in mm.
        pressure: p at the step's start (MPa).
        coefficient: coefficient of friction μ.
        width: ε, the slip (mm) beyond which friction is nearly full.

    Example:
        A slip of 3 mm with ε = 4 mm at μ p = 1 MPa: √(9 + 16) − 4 mJ/mm².

        >>> from dolfingrip.forms.evaluate import number
        >>> number(energy(ufl.as_vector([0, 0, 3.0]), 2.0, 0.5, 4.0))
        1.0
    """
    return coefficient * pressure * (ufl.sqrt(ufl.inner(slip, slip) + width**2) - width)
