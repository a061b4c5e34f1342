"""Stress of a network whose chains detach and attach anew once they are stretched too much.

    ψ = m/2 (A : C̄ − ln det A − 3),   q = A : C̄ − ln det A − 3 ≤ q_y,

with A an internal metric that moves towards C̄⁻¹ as far as q ≤ q_y asks: rate-independent and, at
small strain, an elastic, perfectly plastic element of shear modulus m that yields at a uniaxial
strain ε_y, q_y = 3 ε_y². Beside an elastic network it gives hysteresis at equilibrium and a
permanent set, as in thermoplastic polyurethane (Qi & Boyce, Mech. Mater. 37, 2005). It is the
transient network of :mod:`dolfingrip.forms.transient_network` with yielding for a clock.

Within a load step A' = ρ A + (1 − ρ) C̄⁻¹, ρ = √(q_y/q) where q > q_y, q taken with A (backward
Euler). The last part gives no stress, and m/2 ρ dq integrates to the incremental potential m/2 q,
or m/2 (2 √(q_y q) − q_y) beyond q_y. As q is convex in A and least at C̄⁻¹, the step from A to A'
never raises it: no dissipation is negative.
"""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms.invariants import isochoric_tensor


def _stretched(strain: Expr, a: Expr) -> Expr:
    """q."""
    return ufl.inner(a, isochoric_tensor(strain)) - ufl.ln(ufl.det(a)) - 3


def energy(strain: Expr, modulus: Expr, a: Expr, limit: Expr) -> Expr:
    """Incremental potential of a load step per reference volume (mJ/mm³).

    Args:
        strain: Green–Lagrange strain at the step's end, (3, 3).
        modulus: m (MPa).
        a: A at the step's start, (3, 3).
        limit: q_y, above 0.

    Example:
        A bar pulled by 0.1 % that yields at 1 % is elastic, with Young's modulus 3m.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> at_rest = ufl.Identity(3)
        >>> pulled = lambda strain: energy(strain, 1.0, at_rest, 3 * 0.01**2)
        >>> round(nominal_stress(pulled, 1.001) / 0.001, 2)
        3.0
    """
    q = _stretched(strain, a)
    beyond = 2 * ufl.sqrt(limit * ufl.max_value(q, limit)) - limit
    return modulus / 2 * ufl.conditional(ufl.lt(q, limit), q, beyond)


def update(strain: Expr, a: Expr, limit: Expr) -> Expr:
    """A' at the step's end, (3, 3)."""
    kept = ufl.sqrt(limit / ufl.max_value(_stretched(strain, a), limit))
    return kept * a + (1 - kept) * ufl.inv(isochoric_tensor(strain))
