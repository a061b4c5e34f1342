"""A finger that sticks to the force sensor's plate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import ufl
from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior
from dolfingrip.forms import friction

if TYPE_CHECKING:
    from dolfingrip.extensions.site import Site

SLIP_mm = 0.02
"""Slip in a load step below which the friction is a spring's."""


class PlateFriction(Effect):
    """Friction between the finger and the force sensor's plate (Coulomb).

    Π += ∫ μ p (√(|s|² + ε²) − ε) dA over the skin that faces the plate, s the slip in a load step,
    ε = 0.02 mm, p the contact pressure at its start (lagged, so an error of the order of the
    load step); see :mod:`dolfingrip.forms.friction`. The plate has no mass and does not move along.

    Prior: μ = 0.6 ± 0.2, thermoplastic polyurethane 0.3 to 1.0.
    Fingerprint: the tip slides less: a loop at any rate, in every cycle; the force up to 1 % higher
    while loading, up to some 100 kPa, then lower, by 6.5 % at 250 kPa; unloading, 2 to 4 % higher
    below 125 kPa. Free bending is untouched.
    Confused with: permanent set (a loop in free bending, too), friction between bellows (a loop
    where they touch), the plate's tilt.
    """

    kind: ClassVar = "dissipative"
    neutral: ClassVar = {"mu": 0.0}

    mu: Annotated[
        float, Prior(0.6, 0.2, "thermoplastic polyurethane, 0.3 to 1.0", positive=True)
    ] = Field(0.6, ge=0, le=10, description="coefficient of friction")

    def terms(self, site: Site) -> Sequence[ufl.Form]:
        if site.plate is None:
            return ()
        before = site.history.u_before
        place = site.history.before(f"{self.name()}.place_mm", site.plate.offset)
        pressure = site.plate.pressure(before, place)
        slip = site.plate.along(site.u - before)
        mu, width = site.constant(self, "mu"), site.fixed(SLIP_mm)
        return [friction.energy(slip, pressure, mu, width) * site.plate.measure]
