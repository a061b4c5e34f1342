"""What lags behind another quantity by a first-order filter, and starts at rest."""

from __future__ import annotations

import math


def lagging(tau_s: float, step_s: float, before: float, now: float, behind: float) -> float:
    """Return the outlet y of τ dy/dt = x − y as a step ends, exact for an x that is linear in it.

    y = x − Δx (1 − exp(−t))/t + (y₀ − x₀) exp(−t), t = Δt/τ. As τ goes to 0, y goes to
    x − τ dx/dt. In a step of no duration y stays, and with τ = 0 it is x.

    Args:
        tau_s: time constant τ.
        step_s: length of the step, 0 at rest.
        before: x₀, as the step starts.
        now: x, as it ends.
        behind: y₀, as the step starts.
    """
    t = step_s / tau_s if tau_s > 0 else math.inf
    # expm1 keeps the digits in a step much shorter than τ; in a step of no duration it is 0/0
    mean = -math.expm1(-t) / t if t > 0 else 1.0
    return now - (now - before) * mean + (behind - before) * math.exp(-t)
