"""Isotropic energies of the isochoric invariants, with stress and tangent written out.

    ψ = W(Ī₁ − 3, Ī₂ − 3),   S = 2 (W₁ A₁ + W₂ A₂),   A_k = ∂Ī_k/∂C

    A₁ = g (I − t/3 C⁻¹),   A₂ = g² (t I − C − ⅔ i₂ C⁻¹)

with t and i₂ the invariants of C itself and g = (det C)^(−1/3). Along a change Ċ

    Ṡ = 2 Σ_k [W_k Ȧ_k + Σ_l W_kl (A_l : Ċ) A_k].

A kernel holds six numbers of W and a few tensors, however long W is (Holzapfel, Nonlinear Solid
Mechanics, 2000, section 6.6).

Sums of any power of the isochoric principal stretches are smooth where stretches coincide, too.
The eigenvalues of C̄ have no derivative where two are equal, as in uniaxial and equibiaxial tension.
But a symmetric function of them is a smooth function of Ī₁ and Ī₂. All is computed from these:

1. The invariants of a square root follow from i₁² = I₁ + 2 i₂ and i₂² = I₂ + 2 i₁ (Hoger & Carlson,
   Q. Appl. Math. 42, 1984). These equations are regular, since i₁ i₂ ≥ 9. Two steps of Newton's
   method solve them to 1e-12. Three roots make A = C̄^(1/8).
2. The logarithm L of A is small and has no trace. Its invariants J₂ = ½ tr L² and J₃ = det L are
   power series in those of A: the series of tr exp L, reverted.
3. The invariants of exp(tL) are the series of the exponential in t² J₂ and t³ J₃. With t = s/2 the
   matrix is C̄^(s/16), and four squarings make it C̄ˢ (scaling and squaring: Higham, Functions of
   Matrices, 2008, section 10.3).

The exponent is a parameter like any other, of either sign. For exponents of the stretches from −8
to 8 the error of the sum is 1e-7 of it up to a stretch of 3 in equibiaxial tension and of 8 in
uniaxial and planar tension; in equibiaxial tension it is 4e-6 at a stretch of 5 and 1e-4 at 8.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, Protocol

import ufl
from ufl.classes import Variable
from ufl.constantvalue import as_ufl
from ufl.core.expr import Expr

from dolfingrip.forms import invariants
from dolfingrip.forms.chain_rule import KnownDerivatives, once
from dolfingrip.forms.jet import Jet, series, variables


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
    def _log(self) -> Pair:
        return logarithm(self.first.f, self.second.f)

    def power_sum(self, exponent: Expr) -> Jet:
        """Sum of the isochoric principal stretches to this power, less 3."""
        return power_sum(self._log, exponent / 2)


class _Tensors:
    """Tensors that all isotropic energies of a strain share, named as above; x is C⁻¹."""

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
    tensors = once(strain, "isotropic", lambda: _Tensors(strain))
    plain = function(tensors.invariants)
    jet = Jet(*(Variable(as_ufl(part), KnownDerivatives(strain)) for part in plain.parts()))
    c, x, g, t, second = tensors.c, tensors.x, tensors.g, tensors.t, tensors.second
    a1, a2, unit = tensors.a1, tensors.a2, tensors.unit

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

    stress = Variable(2 * (jet.x * a1 + jet.y * a2), KnownDerivatives(strain, rate=stress_rate))

    def rate(strain_rate: Expr) -> Expr:
        return ufl.inner(stress, strain_rate)

    return Variable(plain.f, KnownDerivatives(strain, stress, rate))


ROOTS = 3
"""Number of square roots before the series of the logarithm is used."""

SQUARINGS = 4
"""Number of squarings after the series of the exponential."""

Pair = tuple[Jet, Jet]

LOG_J2 = {(1, 0): 1, (2, 0): -1 / 12, (0, 1): -1 / 60, (3, 0): 1 / 90, (1, 1): 1 / 210,
          (4, 0): -1 / 560, (2, 1): -1 / 840, (5, 0): 1 / 3150, (0, 2): -1 / 18480,
          (3, 1): 1 / 3465, (6, 0): -1 / 16632}  # fmt: skip
LOG_J3 = {(0, 0): 2, (1, 0): -1 / 6, (2, 0): 1 / 45, (0, 1): 1 / 378, (3, 0): -1 / 280,
          (1, 1): -13 / 12600, (4, 0): 1 / 1575, (2, 1): 16 / 51975, (5, 0): -1 / 8316}  # fmt: skip
"""J₂ and J₃/D of the logarithm: coefficients of SᵃD²ᵇ, S and D half the sum and half the
difference of i₁ − 3 and i₂ − 3. S is of second order in the strain, D of third; terms up to the
12th are there, in J₃ up to the 13th."""

EXP_EVEN = {(1, 0): 1, (2, 0): 1 / 12, (3, 0): 1 / 360, (0, 1): 1 / 240, (4, 0): 1 / 20160,
            (1, 1): 1 / 5040, (5, 0): 1 / 1814400, (2, 1): 1 / 241920, (6, 0): 1 / 239500800,
            (3, 1): 1 / 19958400, (0, 2): 1 / 159667200}  # fmt: skip
EXP_ODD = {(0, 0): 1 / 2, (1, 0): 1 / 24, (2, 0): 1 / 720, (3, 0): 1 / 40320, (0, 1): 1 / 120960,
           (4, 0): 1 / 3628800, (1, 1): 1 / 3628800}  # fmt: skip
"""½ (tr e^L + tr e^−L) − 3 and ½ (tr e^L − tr e^−L)/J₃: coefficients of J₂ᵃJ₃²ᵇ, from tr Lⁿ by
Newton's identities."""


def square_root(first: Expr, second: Expr) -> tuple[Jet, Jet]:
    """Invariants less 3 of A^(1/2), and their derivatives, from the invariants of A; det A = 1.

    Example:
        4, 1, ¼ have the roots 2, 1, ½, whose sums are 3.5.

        >>> a, b = square_root(2.25, 2.25)
        >>> round(a.f, 9), round(b.f, 9)
        (0.5, 0.5)
    """
    # to a tenth and better; then Newton's method
    b = (second + 3 + 2 * (first + 9) ** 0.5) ** 0.5
    a = (first + 3 + 2 * b) ** 0.5
    b = (second + 3 + 2 * a) ** 0.5 - 3
    a = a - 3
    for _ in range(2):
        f, g = a * (a + 6) - 2 * b - first, b * (b + 6) - 2 * a - second
        scale = 0.5 / ((3 + a) * (3 + b) - 1)
        a, b = a - ((3 + b) * f + g) * scale, b - ((3 + a) * g + f) * scale
    # of the equations: i₁ di₁ − di₂ = dI₁/2, i₂ di₂ − di₁ = dI₂/2
    scale = 1 / ((3 + a) * (3 + b) - 1)
    ax, bx = (3 + b) * scale / 2, scale / 2
    ay, by = bx, (3 + a) * scale / 2

    def second_(u: Expr, v: Expr) -> tuple[Expr, Expr]:
        """Second derivatives of both from i₁ d²i₁ − d²i₂ = −u and i₂ d²i₂ − d²i₁ = −v."""
        return -((3 + b) * u + v) * scale, -((3 + a) * v + u) * scale

    axx, bxx = second_(ax * ax, bx * bx)
    axy, bxy = second_(ax * ay, bx * by)
    ayy, byy = second_(ay * ay, by * by)
    return Jet(a, ax, ay, axx, axy, ayy), Jet(b, bx, by, bxx, bxy, byy)


def logarithm(first: Expr, second: Expr) -> Pair:
    """J₂ and J₃ of the logarithm of C̄^(1/8), from Ī₁ − 3 and Ī₂ − 3 of C̄."""
    a, b = square_root(first, second)
    for _ in range(ROOTS - 1):
        root = square_root(a.f, b.f)
        a, b = root[0].of(a, b), root[1].of(a, b)
    s, d = variables((a.f + b.f) / 2, (a.f - b.f) / 2)
    squared = d * d
    half, difference = (a + b) * 0.5, (a - b) * 0.5
    j2, j3 = series(LOG_J2, s, squared), d * series(LOG_J3, s, squared)
    return j2.of(half, difference), j3.of(half, difference)


def power_sum(log: Pair, s: Expr) -> Jet:
    """Sum of the eigenvalues of C̄ˢ, less 3, with its derivatives by Ī₁ and Ī₂.

    Args:
        log: logarithm of C̄, from :func:`logarithm`.
        s: exponent of either sign; the exponent of the stretches is 2s.

    Example:
        The stretches 2, 1, ½ to the power −3, by C̄'s −3/2: 8 + 1 + 1/8.

        >>> round(3 + power_sum(logarithm(2.25, 2.25), -1.5).f, 9)
        9.125
    """
    t = s * 2.0 ** (ROOTS - SQUARINGS)
    j2, j3 = variables(t**2 * log[0].f, t**3 * log[1].f)
    squared = j3 * j3
    even = series(EXP_EVEN, j2, squared)
    odd = j3 * series(EXP_ODD, j2, squared)
    a, b = even + odd, even - odd
    for _ in range(SQUARINGS - 1):
        a, b = a * (a + 6) - b * 2, b * (b + 6) - a * 2
    return (a * (a + 6) - b * 2).of(log[0] * t**2, log[1] * t**3)
