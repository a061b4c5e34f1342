"""A loss factor that is nearly the same over decades of frequency, as that of silicone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, ClassVar

import ufl
from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Prior, Site
from dolfingrip.extensions.kinds import Network, Viscous
from dolfingrip.sections.section import Ratio, Refusal

type Number = Expr | float


class LossFactor(Viscous):
    """Nearly constant loss factor (Prony series spaced by decades, finite strain).

    tan δ = η from ``lowest_Hz`` to ``highest_Hz``, to a tenth; beyond them the loss fades as that
    of a Maxwell branch does. The branches relax at the frequencies f₀ rᵏ, r ≤ 10, from one end to
    the other, and their moduli follow a power law, μₖ = μ∞ (rⁿ − 1) rⁿᵏ with n = 2/π atan η: all
    branches up to the k-th make the modulus μ∞ rⁿ⁽ᵏ⁺¹⁾, so that it grows by rⁿ from one to the
    next, as causality demands of this loss (Kramers & Kronig). The first and the last branch have
    the loss of those that a series without ends would have beyond them. ``material.mu_MPa`` is
    the modulus at rest, μ∞; the bulk is elastic.

    Prior: η from 0.05 to 0.25 for cast silicone, from 1 to 100 Hz.
    Fingerprint: swings decay by the same ratio exp(−π η) at all frequencies of the range, and the
    finger is stiffer in motion than at rest: for η = 0.11 by 10 % at the lowest frequency, and by
    17 % more for each decade. A coupon that is pulled within seconds is stiffer at its start; ramps
    of minutes do not feel it.
    Confused with: Prony, whose loss has a peak at one frequency; inertia and a log of set points,
    by a late and smaller swing.
    """

    neutral: ClassVar = {"loss_factor": 0.0}
    alike: ClassVar = ("lowest_Hz", "highest_Hz")

    loss_factor: Annotated[
        Ratio, Prior(0.12, 0.06, "cast silicones, 0.05 to 0.25", positive=True)
    ] = Field(0.12, ge=0, le=1, description="loss modulus by storage modulus, tan δ")
    lowest_Hz: Annotated[
        float, Prior(1.0, 1.0, "engineering guess: as slow as ring-downs are", positive=True)
    ] = Field(1.0, gt=0, description="frequency from which the loss factor holds")
    highest_Hz: Annotated[
        float, Prior(100.0, 100.0, "engineering guess: as fast as ring-downs are", positive=True)
    ] = Field(100.0, gt=0, description="frequency up to which the loss factor holds")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        if not 2 <= self.highest_Hz / self.lowest_Hz <= 1e6:
            yield Refusal("highest_Hz", "allowed: 2 to 1e6 times lowest_Hz")

    def _series(self, loss: Number, lowest: Number, highest: Number) -> list[tuple[Expr, Number]]:
        """Moduli by μ∞, and times (s), of numbers or constants."""
        spaces = max(1, math.ceil(math.log10(self.highest_Hz / self.lowest_Hz) - 1e-9))
        r, n = (highest / lowest) ** (1 / spaces), 2 / math.pi * ufl.atan(loss)
        ends = {0: 1 + 2 / (r ** (1 + n) - 1), spaces: 1 + 2 / (r ** (1 - n) - 1)}
        return [
            ((r**n - 1) * r ** (n * k) * ends.get(k, 1.0), 1 / (2 * math.pi * lowest * r**k))
            for k in range(spaces + 1)
        ]

    def networks(self, site: Site) -> Sequence[Network]:
        keys = ("loss_factor", "lowest_Hz", "highest_Hz")
        series = self._series(*(site.constant(self, key) for key in keys))
        return [(part * site.mu, tau) for part, tau in series]

    def branches(self) -> tuple[Sequence[float], Sequence[float]]:
        series = self._series(self.loss_factor, self.lowest_Hz, self.highest_Hz)
        moduli = [float(part) for part, _ in series]
        instantaneous = 1 + sum(moduli)
        return [m / instantaneous for m in moduli], [float(tau) for _, tau in series]
