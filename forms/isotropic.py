"""Isotropic energies of the isochoric invariants, with stress and tangent written out.

    ψ = W(Ī₁ − 3, Ī₂ − 3),   S = 2 (W₁ A₁ + W₂ A₂),   A_k = ∂Ī_k/∂C

    A₁ = g (I − t/3 C⁻¹),   A₂ = g² (t I − C − ⅔ i₂ C⁻¹)

with t and i₂ the invariants of C itself and g = (det C)^(−1/3). Along a change Ċ

    Ṡ = 2 Σ_k [W_k Ȧ_k + Σ_l W_kl (A_l : Ċ) A_k].

A kernel holds six numbers of W and a few tensors, however long W is (Holzapfel, Nonlinear Solid
Mechanics, 2000, section 6.6).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, Protocol

import ufl
from ufl.classes import Variable
from ufl.constantvalue import as_ufl
from ufl.core.expr import Expr

from dolfingrip.forms import invariants, stretch_powers
from dolfingrip.forms.chain_rule import Known, once
from dolfingrip.forms.jet import Jet, variables


class Invariants(Protocol):
    """The variables of an isotropic energy, with derivatives by two numbers.

    Attributes:
        first, second: Ī₁ − 3 and Ī₂ − 3.
    """

    @property
    def first(self) -> Jet: ...

    @property
    def second(self) -> Jet: ...

    def power_sum(self, exponent: Any) -> Jet:
        """Sum of the isochoric principal stretches to this power, less 3."""
        ...


class OfTensor:
    """Invariants of C̄, with derivatives by Ī₁ and Ī₂.

    Args:
        first, second: Ī₁ − 3 and Ī₂ − 3.
    """

    def __init__(self, first: Expr, second: Expr) -> None:
        self.first, self.second = variables(first, second)

    @cached_property
    def _log(self) -> stretch_powers.Pair:
        return stretch_powers.logarithm(self.first.f, self.second.f)

    def power_sum(self, exponent: Expr) -> Jet:
        """Sum of the isochoric principal stretches to this power, less 3."""
        return stretch_powers.power_sum(self._log, exponent / 2)


class _Tensors:
    """What all isotropic energies of a strain have in common, named as above; x is C⁻¹."""

    def __init__(self, strain: Expr) -> None:
        self.invariants = OfTensor(*invariants.isochoric(strain))
        self.unit = ufl.Identity(3)
        self.c = c = invariants.right_cauchy_green(strain)
        self.x = ufl.inv(c)
        self.g = ufl.det(c) ** (-1 / 3)
        self.t = ufl.tr(c)
        self.second = (self.t**2 - ufl.inner(c, c)) / 2
        self.a1 = self.g * (self.unit - (self.t / 3) * self.x)
        self.a2 = self.g**2 * (self.t * self.unit - c - (2 / 3 * self.second) * self.x)


def energy(strain: Expr, function: Callable[[Invariants], Jet]) -> Expr:
    """Strain energy per reference volume (MPa = mJ/mm³).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        function: W with its derivatives (mJ/mm³).

    Example:
        W = Ī₁ − 3 in a bar of constant volume has P = 2 (λ − λ⁻²).

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, lambda i: i.first), 2.0), 9)
        3.5
    """
    known = once(strain, "isotropic", lambda: _Tensors(strain))
    plain = function(known.invariants)
    jet = Jet(*(Variable(as_ufl(part), Known(strain)) for part in plain.parts()))
    c, x, g, t, second = known.c, known.x, known.g, known.t, known.second
    a1, a2, unit = known.a1, known.a2, known.unit

    def stress_rate(strain_rate: Expr) -> Expr:
        dc = 2 * strain_rate
        volume, trace = ufl.inner(x, dc), ufl.tr(dc)
        along1, along2 = ufl.inner(a1, dc), ufl.inner(a2, dc)
        w1, w2 = jet.x * g, jet.y * g**2
        change = (w1 * t / 3 + w2 * second * (2 / 3)) * (x * dc * x)
        change += w2 * (trace * unit - dc)
        change -= (trace * (w1 / 3) + (t * trace - ufl.inner(c, dc)) * (w2 * (2 / 3))) * x
        change += (along1 * jet.xx + along2 * jet.xy - volume * (jet.x / 3)) * a1
        change += (along1 * jet.xy + along2 * jet.yy - volume * (jet.y * (2 / 3))) * a2
        return 2 * change

    stress = Variable(2 * (jet.x * a1 + jet.y * a2), Known(strain, rate=stress_rate))

    def rate(strain_rate: Expr) -> Expr:
        return ufl.inner(stress, strain_rate)

    return Variable(plain.f, Known(strain, stress, rate))
