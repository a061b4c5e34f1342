"""Coulomb friction, smooth at no slip."""

import ufl
from ufl.core.expr import Expr


def energy(slip: Expr, pressure: Expr, coefficient: Expr, width: Expr) -> Expr:
    """Incremental potential of a load step per area (mJ/mm²), zero at no slip.

    ψ = μ p (√(|s|² + ε²) − ε)

    whose traction is that of Coulomb's law where the slip s is long against ε, and a spring's
    where it is not. With the pressure p held it is a potential, and its dissipation, traction times
    slip, never negative.

    Args:
        slip: tangential displacement since the step's start, (3,), in mm.
        pressure: p at the step's start (MPa).
        coefficient: μ.
        width: ε (mm).
    """
    return coefficient * pressure * (ufl.sqrt(ufl.inner(slip, slip) + width**2) - width)
