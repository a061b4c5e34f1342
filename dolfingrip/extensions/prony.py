"""Viscoelasticity: one to three Maxwell branches in parallel with the elastic solid."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Prior, Site
from dolfingrip.extensions.kinds import Network, Viscous
from dolfingrip.sections.section import Ratio, Refusal

SERIES = Field(strict=False, min_length=1, max_length=3)
"""Numbers of terms of the series."""


class Prony(Viscous):
    """Viscoelasticity (Prony series, finite strain).

    μ(t) = μ₀ (1 − Σ gᵢ (1 − exp(−t/τᵢ))) in shear; the bulk is elastic. ``material.mu_MPa`` is the
    relaxed modulus μ∞ = μ₀ (1 − Σ gᵢ). Each branch is a network of modulus gᵢ μ₀ that relaxes (see
    :mod:`dolfingrip.forms.transient_network`); its dissipation is never negative.

    Prior: Σg from 0.1 to 0.3 and τ from 1 to 1000 s, for thermoplastic polyurethane.
    Fingerprint: angle and force lag behind the pressure. Loading and unloading form a loop whose
    width depends on the rate, and readings creep during a wait. The finger is stiffer in faster
    ramps: at 250 kPa the angle is lower by 18 % at 100 kPa/s and by 3 % at 2 kPa/s, the force by 8
    and 1 %. Up to 5° are left as the finger is vented.
    Confused with: Mullins softening (a loop that does not depend on the rate and shrinks after the
    first cycle), line lag (a loop that closes as the pressure settles), friction.
    """

    neutral: ClassVar = {"g": [0.0]}

    g: Annotated[
        tuple[Annotated[Ratio, Field(ge=0, lt=1)], ...],
        SERIES,
        Prior(0.2, 0.1, "thermoplastic polyurethane, 0.1 to 0.3 in all", positive=True),
    ] = Field((0.2,), description="part of the instantaneous shear modulus that relaxes, by branch")
    tau_s: Annotated[
        tuple[Annotated[float, Field(gt=0)], ...],
        SERIES,
        Prior(30.0, 60.0, "thermoplastic polyurethane, 1 to 1000 s", positive=True),
    ] = Field((10.0,), description="relaxation time, by branch")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        if len(self.tau_s) != len(self.g):
            yield Refusal("tau_s", f"allowed: as many numbers as g has, {len(self.g)}")
        if sum(self.g) >= 1:
            yield Refusal("g", "allowed: numbers whose sum is below 1")

    def networks(self, site: Site) -> Sequence[Network]:
        g, tau = site.constant(self, "g"), site.constant(self, "tau_s")
        instantaneous = site.mu / (1 - sum(g[i] for i in range(len(self.g))))
        return [(g[i] * instantaneous, tau[i]) for i in range(len(self.g))]

    def branches(self) -> tuple[Sequence[float], Sequence[float]]:
        return self.g, self.tau_s
