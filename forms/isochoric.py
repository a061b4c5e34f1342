"""Energies of the isochoric strain, with stress and tangent written out.

    ψ(Ē),   Ē = (C̄ − I)/2,   C̄ = g C,   g = (det C)^(−1/3)

With S̄ = ∂ψ/∂Ē the stress is (Holzapfel, Nonlinear Solid Mechanics, 2000, eq. 6.90)

    S = g (S̄ − ⅓ (S̄ : C) C⁻¹).
"""

from __future__ import annotations

from collections.abc import Callable

import ufl
from ufl.classes import Variable
from ufl.core.expr import Expr

from dolfingrip.forms import invariants
from dolfingrip.forms.chain_rule import KnownDerivatives, by_variable, strain_variable


def energy(density: Callable[[Expr], Expr], strain: Expr) -> Expr:
    """A density at the isochoric strain (MPa = mJ/mm³).

    Args:
        density: ψ of the Green–Lagrange strain, (3, 3) (mJ/mm³).
        strain: Green–Lagrange strain E, (3, 3).

    Example:
        tr Ē of a cube that is only larger is 0, and so is its stress.

        >>> from dolfingrip.forms.evaluate import nominal_stress, number
        >>> larger = ufl.as_matrix([[0.7, 0, 0], [0, 0.7, 0], [0, 0, 0.7]])
        >>> round(number(energy(ufl.tr, larger)), 9)
        0.0
        >>> round(nominal_stress(lambda strain: 2 * energy(ufl.tr, strain), 2.0), 9)
        3.5
    """
    c = invariants.right_cauchy_green(strain)
    isochoric = strain_variable((invariants.isochoric_tensor(strain) - ufl.Identity(3)) / 2)
    value = density(isochoric)
    inner = by_variable(value, isochoric)
    g = ufl.det(c) ** (-1 / 3)
    stress = g * (inner - (ufl.inner(inner, c) / 3) * ufl.inv(c))

    def rate(strain_rate: Expr) -> Expr:
        return ufl.inner(stress, strain_rate)

    return Variable(value, KnownDerivatives(strain, stress, rate))
