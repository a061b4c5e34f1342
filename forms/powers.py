"""Powers of the isochoric right Cauchy–Green tensor, from its invariants alone.

For −1 < s < 2 each eigenvalue λ of C̄ has

    λˢ = 1 + s (λ − 1) − sin πs/π ∫₀¹ xˢ (1 − x)¹⁻ˢ (λ − 1)²/(λ + (1 − λ) x) dx,

which follows from λˢ = sin πs/π ∫₀^∞ tˢ⁻¹ λ/(λ + t) dt (Higham, Functions of Matrices, 2008,
section 1.7) with two terms at λ = 1 taken out and t = x/(1 − x). Summed over the eigenvalues the
integrand is a rational function of the invariants, since Π (λᵢ + t) = t³ + Ī₁t² + Ī₂t + 1. So the
eigenvalues themselves are not needed. That matters, as their derivatives do not exist where two
are equal. The integral is taken by a rule that interpolates at Chebyshev nodes. Its weights are
polynomials in s, so that s is a parameter like any other.
"""

import numpy as np
from ufl.core.expr import Expr

NODES = 4
"""Error of an incompressible bar's stress at a stretch of 1.5: 1e-5 at s = 1/2, 3e-4 at 1/4 and
7e-4 at 5/4; at 2 it is 1e-3 and, at 5/4, 7e-3. More nodes make larger kernels."""


def _rule(s: Expr) -> list[tuple[float, Expr]]:
    """Nodes x and weights w, ∫ xˢ (1 − x)¹⁻ˢ f(x) dx = ½ s (1 − s) π/sin πs Σ w f(x)."""
    nodes = (1 - np.cos(np.arange(1, NODES + 1) * np.pi / (NODES + 1))) / 2
    lagrange = np.linalg.inv(np.vander(nodes, increasing=True))
    moments = [1.0 + 0 * s]
    for k in range(NODES - 1):
        moments.append(moments[-1] * (s + 1 + k) / (3 + k))
    return [
        (float(x), sum(float(part) * moment for part, moment in zip(column, moments, strict=True)))
        for x, column in zip(nodes, lagrange.T, strict=True)
    ]


def spread(first: Expr, second: Expr, s: Expr) -> Expr:
    """R = Σᵢ ∫ … over all three eigenvalues, by which tr C̄ˢ − 3 = s (Ī₁ − 3) − ½ s (1 − s) R.

    Args:
        first: Ī₁ − 3.
        second: Ī₂ − 3.
        s: exponent, from above −1 to below 2.

    Example:
        √λ = 2, 1, ½ are the roots of λ = 4, 1, ¼, whose Ī₁ − 3 = Ī₂ − 3 = 2.25: the sum of the
        roots is 3.5, here with the error of the rule at stretches of 2.

        >>> from dolfingrip.forms.evaluate import number
        >>> round(3 + (2.25 - number(spread(2.25, 2.25, 0.5)) / 4) / 2, 2)
        3.5
    """
    found = 0.0
    for x, weight in _rule(s):
        above = (
            first * (1 + 3 * x)
            + second * (1 - 3 * x)
            + first * (first * x**2 + second * (x * (1 - x)))
        )
        below = 1 + first * (x**2 * (1 - x)) + second * (x * (1 - x) ** 2)
        found += weight * above / below
    return found
