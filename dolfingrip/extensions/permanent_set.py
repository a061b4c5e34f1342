"""A finger that does not come back: part of the network yields."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Prior, Site, StrainEnergy
from dolfingrip.forms import yielding_network
from dolfingrip.sections.section import Ratio


class PermanentSet(Effect):
    """Permanent set: a network that yields, in parallel with the elastic solid.

    ψ += g μ/2 (A : C̄ − ln det A − 3). The metric A is the shape in which the network carries no
    stress; it yields towards C̄⁻¹ at a uniaxial strain ε_y (see
    :mod:`dolfingrip.forms.yielding_network`). A bar that is pulled beyond 2 ε_y and let go keeps a
    strain of about g ε_y.

    Prior: a set of 1 to 5° is some 5 % of the angle, so g ε_y is 1 % at wall strains of 20 %:
    g = 0.2 ± 0.1 and ε_y = 0.05 ± 0.03. How the product splits is an engineering guess.
    Fingerprint: the angle does not return to 0 after the first cycle: 7.5° of 140° are left, and
    0.01 N. Loading and unloading form a loop in every cycle that does not depend on the rate, −11
    and +4 % of the angle at 125 kPa. After each turn the finger is stiffer at first.
    Confused with: the angle's drift, viscoelasticity after a short rest (a set that goes away),
    friction on the plate, Mullins softening (a loop in the first cycle only, no set).
    """

    kind: ClassVar = "dissipative"
    place: ClassVar = 2

    g: Annotated[Ratio, Prior(0.2, 0.1, "set of 1 to 5°; engineering guess", positive=True)] = (
        Field(0.2, ge=0, le=100, description="shear modulus that yields, by material.mu_MPa")
    )
    yield_strain: Annotated[
        Ratio, Prior(0.05, 0.03, "set of 1 to 5°; engineering guess", positive=True)
    ] = Field(0.05, gt=0, le=10, description="uniaxial strain at which it yields")

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        g, strain_y = site.constant(self, "g"), site.constant(self, "yield_strain")
        limit = 3 * strain_y**2
        a = site.remember(self, "A", np.eye(3))
        site.history.evolve(a, yielding_network.update(site.strain, a, limit))

        def density(strain: Expr) -> Expr:
            return base(strain) + yielding_network.energy(strain, g * site.mu, a, limit)

        return density
