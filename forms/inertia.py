"""Inertia of a load step by the scheme of Hilber, Hughes and Taylor, as an incremental potential.

    π = ρ k/2 |u − û|²,   k = 1/((1 + α) β Δt²),   û = ũ + α β Δt² g₀,
    ũ = u₀ + Δt v₀ + δ Δt² a₀,

with β = (1 − α)²/4, γ = 1/2 − α and δ = 1/2 − β. At the step's end a = (u − ũ)/(βΔt²) and
v = v₀ + Δt ((1 − γ) a₀ + γ a). If Π is the potential of all else, π makes ρ a + (1 + α) Π' − α Π₀'
vanish, where Π₀' = ρ g₀ is Π' at the step's start, so that g = (α g₀ − a)/(1 + α) at its end.

α = 0 is Newmark's scheme of average acceleration, which keeps the energy of linear vibrations.
Down to −1/3 the scheme damps motions that the step does not resolve; it is of second order in Δt
and stable for linear problems of any step (Hilber, Hughes & Taylor, Earthquake Eng. Struct. Dyn. 5,
1977). Implicit Euler, of first order, has α = δ = 0 and β = γ = 1.
"""

from typing import Final, NamedTuple

import ufl
from ufl.core.expr import Expr


class Scheme(NamedTuple):
    """Numbers of a scheme.

    Attributes:
        alpha: α, from −1/3 to 0.
        beta, gamma: Newmark's β and γ.
        delta: δ, part of the acceleration at a step's start in the prediction of its end.
    """

    alpha: float
    beta: float
    gamma: float
    delta: float


IMPLICIT_EULER: Final = Scheme(0.0, 1.0, 1.0, 0.0)
"""It takes the energy of vibrations in few steps, as for a way to rest."""


def scheme(alpha: float) -> Scheme:
    """The scheme of second order with the least error for its damping.

    Args:
        alpha: α, from −1/3 to 0.

    Returns:
        α, β, γ and δ.

    Example:
        Newmark's average acceleration.

        >>> scheme(0.0)
        Scheme(alpha=0.0, beta=0.25, gamma=0.5, delta=0.25)
    """
    beta = (1 - alpha) ** 2 / 4
    return Scheme(alpha, beta, 0.5 - alpha, 0.5 - beta)


def energy(u: Expr, ahead: Expr, density: Expr, stiffness: Expr) -> Expr:
    """Incremental potential of a load step per reference volume (mJ/mm³).

    Args:
        u: displacement at the step's end (mm), (3,).
        ahead: û (mm), (3,).
        density: ρ (t/mm³).
        stiffness: k (1/s²); 0 where no time passes.

    Example:
        1 g/cm³ that is 2 mm ahead of its prediction, β = 1/4 and a step of 1 ms.

        >>> from dolfingrip.forms.evaluate import number
        >>> there, at = ufl.as_vector([2, 0, 0]), ufl.as_vector([0, 0, 0])
        >>> round(number(energy(there, at, 1e-9, 4e6)), 9)
        0.008
    """
    away = u - ahead
    return density * stiffness / 2 * ufl.inner(away, away)
