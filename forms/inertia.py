"""Inertia of a load step by the scheme of Hilber, Hughes and Taylor, as an incremental potential.

    π = ρ/(1 + α) (|u − ũ|²/(2βΔt²) − α g₀·u),   ũ = u₀ + Δt v₀ + (1/2 − β) Δt² a₀,

with β = (1 − α)²/4 and γ = 1/2 − α. At the step's end a = (u − ũ)/(βΔt²) and
v = v₀ + Δt ((1 − γ) a₀ + γ a). If Π is the potential of all else, π makes ρ a + (1 + α) Π' − α Π₀'
vanish, where Π₀' = ρ g₀ is Π' at the step's start, so that g = (α g₀ − a)/(1 + α) at its end.

α = 0 is Newmark's scheme of average acceleration, which keeps the energy of linear vibrations.
Down to −1/3 the scheme damps motions that the step does not resolve; it is of second order in Δt
and stable for linear problems of any step (Hilber, Hughes & Taylor, Earthquake Eng. Struct. Dyn. 5,
1977).
"""

from typing import NamedTuple

import ufl
from ufl.core.expr import Expr


class Scheme(NamedTuple):
    """Numbers of the scheme.

    Attributes:
        alpha: α, from −1/3 to 0.
        beta, gamma: Newmark's β and γ.
    """

    alpha: float
    beta: float
    gamma: float


def scheme(alpha: float) -> Scheme:
    """The scheme of second order with the least error for its damping.

    Args:
        alpha: α, from −1/3 to 0.

    Returns:
        α, β and γ.

    Example:
        Newmark's average acceleration.

        >>> scheme(0.0)
        Scheme(alpha=0.0, beta=0.25, gamma=0.5)
    """
    return Scheme(alpha, (1 - alpha) ** 2 / 4, 0.5 - alpha)


def energy(u: Expr, predicted: Expr, before: Expr, density: Expr, rate: Expr, alpha: Expr) -> Expr:
    """Incremental potential of a load step per reference volume (mJ/mm³).

    Args:
        u: displacement at the step's end (mm), (3,).
        predicted: ũ (mm), (3,).
        before: g₀ (mm/s²), (3,); 0 where no time passes.
        density: ρ (t/mm³).
        rate: 1/(βΔt²) (1/s²); 0 where no time passes.
        alpha: α (–).

    Example:
        1 g/cm³ that is 2 mm ahead of its prediction, β = 1/4 and a step of 1 ms.

        >>> from dolfingrip.forms.evaluate import number
        >>> ahead, at = ufl.as_vector([2, 0, 0]), ufl.as_vector([0, 0, 0])
        >>> round(number(energy(ahead, at, at, 1e-9, 4e6, 0.0)), 9)
        0.008
    """
    away = u - predicted
    work = rate / 2 * ufl.inner(away, away) - alpha * ufl.inner(before, u)
    return density / (1 + alpha) * work
