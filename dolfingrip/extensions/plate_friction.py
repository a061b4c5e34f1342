"""A finger that sticks to the force sensor's plate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import ufl
from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior
from dolfingrip.forms import friction

if TYPE_CHECKING:
    from dolfinx import fem
    from ufl.core.expr import Expr

    from dolfingrip.extensions.site import Site

SLIP_mm = 0.05
"""Slip in a load step below which the friction is a spring's."""

LEAST_MPa = 1e-6
"""Cavity pressure that is told from none."""


class PlateFriction(Effect):
    """Friction between the finger and the force sensor's plate (Coulomb).

    Π += ∫ μ p (√(|s|² + ε²) − ε) dA over the skin that faces the plate, s the slip in a load step,
    ε = 0.05 mm; see :mod:`dolfingrip.forms.friction`. p is the contact pressure at the step's start
    (lagged, as a potential needs it), fading as the cavity's pressure does: held, it would keep a
    finger stuck to a plate that it has left. The plate has no mass and does not move along.

    Prior: μ = 0.6 ± 0.2, thermoplastic polyurethane 0.3 to 1.0.
    Fingerprint: the tip slides less: a loop at any rate, in every cycle; the force 0.5 % higher
    while loading up to 50 kPa, then lower, by 5.4 % at 250 kPa; unloading, 2 to 4 % higher between
    60 and 160 kPa. Free bending is untouched.
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
        if site.pressure is not None:
            pressure *= self._left(site, site.pressure)
        mu, width = site.constant(self, "mu"), site.fixed(SLIP_mm)
        return [friction.energy(slip, pressure, mu, width) * site.plate.measure]

    def _left(self, site: Site, now: fem.Constant) -> Expr:
        """What a load step leaves of the cavity's pressure, at most 1."""
        before = site.history.before(f"{self.name()}.cavity_MPa", now)
        some = ufl.gt(before, LEAST_MPa)
        left = ufl.max_value(now, 0.0) / ufl.conditional(some, before, 1.0)
        return ufl.conditional(some, ufl.min_value(left, 1.0), 1.0)
