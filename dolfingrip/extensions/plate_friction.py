"""A finger that sticks to the force sensor's plate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar

import ufl
from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior, Site
from dolfingrip.sections.section import Ratio


class PlateFriction(Effect):
    """Friction between the finger and the force sensor's plate (Coulomb).

    Π += Σ μ N f0(|s|) over the nodes of the skin that touch the plate, N their normal forces, s the
    slip in a load step and the elastic displacement of nodes that stuck before it: up to ε = 0.02
    mm friction is a spring, beyond it μN; see :mod:`dolfingrip.mechanics.contact.friction`. The
    plate is fixed along its plane.

    Prior: μ = 0.6 ± 0.2, thermoplastic polyurethane 0.3 to 1.0.
    Fingerprint: the tip slides less: a loop at any rate, in every cycle; the force 3 % higher while
    loading up to 60 kPa, then lower from 115 kPa on, by 6.9 % at 250 kPa; unloading, 2 to 3.5 %
    higher between 20 and 100 kPa. Free bending is untouched.
    Confused with: permanent set (a loop in free bending, too), friction between bellows (a loop
    where they touch), the plate's tilt.
    """

    kind: ClassVar = "dissipative"
    felt_by: ClassVar = ("plate",)

    mu: Annotated[
        Ratio, Prior(0.6, 0.2, "thermoplastic polyurethane, 0.3 to 1.0", positive=True)
    ] = Field(0.6, ge=0, le=10, description="coefficient of friction")

    def terms(self, site: Site) -> Sequence[ufl.Form]:
        if site.plate is not None:
            site.add_friction(self, "mu", site.plate)
        return ()
