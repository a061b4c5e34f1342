"""A material that softens and keeps more set with the number of cycles."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar

import numpy as np
import ufl
from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Prior, Site, StrainEnergy
from dolfingrip.forms import yielding_network
from dolfingrip.sections.section import Ratio


class Fatigue(Effect):
    """A material that softens and keeps more set with the number of cycles.

    ψ ← exp(−s L) ψ + g L μ/2 (A : C̄ − ln det A − 3), L = log₁₀ N in the cycle N: moduli fall by the
    same part with each tenfold number of cycles, and a network that yields, as that of
    ``permanent_set``, grows beside the elastic solid. A bar that is pulled beyond 2 ε_y and let go
    keeps a strain of about g L ε_y. Nothing has changed in the first cycle. The number is the one
    that the protocol tells, so that of many cycles some may be simulated.

    Prior: s = 0.03 ± 0.03 for each decade, elastomers at half their strength; g = 0.05 ± 0.05 and
    ε_y = 0.05 (engineering guesses).
    Fingerprint: the angle grows in proportion to log N at all pressures, and so does what is left
    without pressure; the first decade takes as much as the third.
    Confused with: Mullins softening, which ends after the first cycle; viscoelasticity and warming,
    which follow the time; a leak that grows, which leaves what is without pressure.
    """

    kind: ClassVar = "dissipative"
    place: ClassVar = 4
    clock: ClassVar = True
    by_decades: ClassVar = True
    neutral: ClassVar = {"softening": 0.0, "g": 0.0}
    alike: ClassVar = ("yield_strain",)

    softening: Annotated[Ratio, Prior(0.03, 0.03, "engineering guess", positive=True)] = Field(
        0.03, ge=0, le=2, description="part of the moduli that is lost in a decade of cycles"
    )
    g: Annotated[Ratio, Prior(0.05, 0.05, "engineering guess", positive=True)] = Field(
        0.05, ge=0, le=100, description="modulus that yields, by mu, for each decade of cycles"
    )
    yield_strain: Annotated[Ratio, Prior(0.05, 0.03, "engineering guess", positive=True)] = Field(
        0.05, gt=0, le=10, description="uniaxial strain at which it yields"
    )

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        softening, g, yields = (site.constant(self, k) for k in ("softening", "g", "yield_strain"))
        limit, decades = 3 * yields**2, ufl.ln(site.cycle) / math.log(10)
        a = site.remember(self, "A", np.eye(3))
        site.history.evolve(a, yielding_network.update(site.strain, a, limit))

        def density(strain: Expr) -> Expr:
            network = yielding_network.energy(strain, g * decades * site.mu, a, limit)
            return ufl.exp(-softening * decades) * base(strain) + network

        return density
