"""Bellows that rub where they touch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar

import ufl
from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior, Site
from dolfingrip.sections.section import FINGERS, Ratio

SOURCE = "thermoplastic polyurethane, 0.3 to 1.0; printed layers: engineering guess"


class BellowsFriction(Effect):
    """Friction between bellows that touch (Coulomb).

    Π += Σ μ N f0(|s|) over the touching pairs of the skin, N their normal forces, s the slip in a
    load step and the elastic displacement of pairs that stuck before it: up to ``slip_mm`` friction
    is a spring, beyond it μN; see :mod:`dolfingrip.mechanics.contact.friction`. It is the law of
    ``plate_friction``. Nothing without ``contact.self_contact``.

    Prior: μ = 0.6 ± 0.2, engineering handbooks' 0.3 to 1.0 for thermoplastic polyurethane, a guess
    for printed layers on one another; slip 0.02 ± 0.01 mm, a numerical choice.
    Fingerprint: none in free bending, where bellows part. Against the plate none before bellows
    touch (140 kPa); then the force is higher by up to 0.6 % at 250 kPa, and while loading by some
    1 mN more than while unloading: a small loop at any rate, in every cycle.
    Confused with: friction on the plate (a loop from the first pressure on, none in free bending),
    Mullins softening, viscoelasticity (a loop below that pressure, too).
    """

    kind: ClassVar = "dissipative"
    felt_by: ClassVar = FINGERS
    shapeless: ClassVar = ("slip_mm",)

    coefficient: Annotated[Ratio, Prior(0.6, 0.2, SOURCE, positive=True)] = Field(
        0.6, ge=0, le=10, description="coefficient of friction"
    )
    slip_mm: Annotated[
        float, Prior(0.02, 0.01, "a numerical choice: engineering guess", positive=True)
    ] = Field(0.02, gt=0, le=1, description="elastic displacement at which friction is full")

    def terms(self, site: Site) -> Sequence[ufl.Form]:
        if site.contact is not None:
            site.add_friction(self, "coefficient", site.contact, self.slip_mm)
        return ()
