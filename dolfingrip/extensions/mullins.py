"""Softening after the first stretch (Mullins effect)."""

from __future__ import annotations

from typing import Annotated, ClassVar

import ufl
from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Prior, Site, StrainEnergy
from dolfingrip.forms import isochoric, pseudo_elastic
from dolfingrip.sections.section import Ratio


class Mullins(Effect):
    """Softening after the first stretch (Mullins effect, Ogden–Roxburgh).

    stress ← η · stress, η = 1 − erf((W − w)/(m + β W))/r, where w is the elastic energy and W the
    largest one that the point has seen; see :mod:`dolfingrip.forms.pseudo_elastic`. The parameter
    is 1/r; at 0 nothing softens. w is taken at the isochoric strain: resistance to a change of
    volume does not soften. The elastic effects soften with the base model, the viscous do not.

    Prior: r from 1.5 to 3 for thermoplastic polyurethane, taken as 2.2 ± 0.5: to first order 1/r
    is 1/2.2 ± 0.5/2.2². m = 0.1 ± 0.1 MPa, the energy at 15 to 20 % strain, and β = 0.1 ± 0.1 are
    engineering guesses.
    Fingerprint: the first unloading, and all that follows up to the same pressure, has larger
    angles and forces than the first loading, by 40 and 10 % half-way back from 250 kPa. From then
    on loading and unloading agree, at any rate.
    Confused with: viscoelasticity (a loop in every cycle, which depends on the rate), permanent
    set (a loop that does not close).
    """

    kind: ClassVar = "dissipative"
    place: ClassVar = 1
    # on the first cycle softening of any m and β has a cosine of 0.996 and more with any other
    alike: ClassVar = ("m_MPa", "beta")
    # the energy at the isochoric strain is not stationary in the pressure
    mixed: ClassVar = False

    inverse_r: Annotated[
        Ratio, Prior(0.4545, 0.1033, "thermoplastic polyurethane, r 1.5 to 3", positive=True)
    ] = Field(0.4545, ge=0, le=1, description="part of the stress that is lost at most")
    m_MPa: Annotated[float, Prior(0.1, 0.1, "engineering guess", positive=True)] = Field(
        0.1, gt=0, le=1000, description="energy per volume below the largest at which it softens"
    )
    beta: Annotated[Ratio, Prior(0.1, 0.1, "engineering guess", positive=True)] = Field(
        0.1, ge=0, le=10, description="share of the largest energy in that energy"
    )

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        inverse_r, m, beta = (site.constant(self, key) for key in ("inverse_r", "m_MPa", "beta"))
        largest = site.remember(self, "largest_MPa", 0.0)

        def virgin(strain: Expr) -> Expr:
            return isochoric.energy(base, strain)

        site.history.evolve(largest, ufl.max_value(largest, virgin(site.strain)))

        def density(strain: Expr) -> Expr:
            softened = pseudo_elastic.energy(virgin(strain), largest, inverse_r, m, beta)
            return base(strain) + softened

        return density
