"""Viscous overstress of a network whose chains detach and reattach: a Maxwell branch.

    ψ = m/2 (A : C̄ − ln det A − 3),   dA/dt = (C̄⁻¹ − A)/τ,

The internal metric A is the shape in which the network carries no stress. It follows C̄⁻¹ with the
relaxation time τ (Green & Tobolsky, J. Chem. Phys. 14, 1946; as an internal variable: Linder,
Tkachuk & Miehe, J. Mech. Phys. Solids 59, 2011). At small strain the network is a Maxwell element
of shear modulus m. After a sudden strain of any size the stress relaxes exactly by exp(−t/τ). The
dissipation m/(2τ) (tr X + tr X⁻¹ − 6), X = C̄A, is never negative.

Within a load step of length Δt C̄⁻¹ is taken as linear in time, from C̄₀⁻¹ on. Then

    A' = r A + s C̄₀⁻¹ + (1 − r − s) C̄⁻¹,   r = exp(−Δt/τ),   s = (1 − r) τ/Δt − r.

The last part gives no stress, since C̄⁻¹ : dC̄ = d ln det C̄ = 0. So the step's incremental
potential is m/2 (r A + s C̄₀⁻¹) : C̄. Its stress is that at A', which is second-order accurate in
time, and its tangent is symmetric.
"""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms.invariants import isochoric_tensor


def weights(step: Expr, tau: Expr) -> tuple[Expr, Expr]:
    """The numbers r and s (–) of a step of length ``step`` (s), which may be 0."""
    x = step / tau
    r = ufl.exp(-x)
    # at small x, (1 − r)/x loses its digits
    series = 1 - x / 2 + x**2 / 6 - x**3 / 24
    mean = ufl.conditional(ufl.lt(x, 1e-3), series, (1 - r) / ufl.max_value(x, 1e-3))
    return r, mean - r


def energy(strain: Expr, modulus: Expr, a: Expr, c_inverse: Expr, step: Expr, tau: Expr) -> Expr:
    """Incremental potential of a load step per reference volume (mJ/mm³).

    Args:
        strain: Green–Lagrange strain at the step's end, (3, 3).
        modulus: m (MPa).
        a: A at the step's start, (3, 3).
        c_inverse: C̄₀⁻¹ at the step's start, (3, 3).
        step: Δt (s).
        tau: relaxation time (s).

    Example:
        A bar at rest pulled to a stretch of 2 within Δt = τ carries 1 − 1/e of its elastic stress,
        μ (λ − λ⁻²) = 1.75 MPa.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> at_rest = ufl.Identity(3)
        >>> ramp = lambda strain: energy(strain, 1.0, at_rest, at_rest, 10.0, 10.0)
        >>> round(nominal_stress(ramp, 2.0) / 1.75, 6)
        0.632121
    """
    r, s = weights(step, tau)
    pull = ufl.inner(r * a + s * c_inverse, isochoric_tensor(strain))
    return modulus / 2 * (pull - 3 * (r + s))


def update(strain: Expr, a: Expr, c_inverse: Expr, step: Expr, tau: Expr) -> tuple[Expr, Expr]:
    """Internal variables at the end of a step.

    Args:
        strain: Green–Lagrange strain E at the step's end, (3, 3).
        a: A at the step's start, (3, 3).
        c_inverse: C̄⁻¹ at the step's start, (3, 3).
        step: length of the step (s).
        tau: relaxation time (s).

    Returns:
        A' and C̄⁻¹ at the step's end, (3, 3) each.
    """
    r, s = weights(step, tau)
    now = ufl.inv(isochoric_tensor(strain))
    return r * a + s * c_inverse + (1 - r - s) * now, now
