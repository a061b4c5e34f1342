"""Stiffer or softer along one direction of the print."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import ufl
from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Elastic
from dolfingrip.forms import transverse_isotropy


class PrintAnisotropy(Elastic):
    """A print that is stiffer or softer along one direction (transverse isotropy).

    ψ += k/2 (Ī₄ − 1)², Ī₄ = a · C̄ a, a = (sin φ, 0, cos φ): the standard reinforcing energy
    (Triantafyllidis & Abeyaratne, J. Appl. Mech. 50, 1983; see
    :mod:`dolfingrip.forms.transverse_isotropy`). At small strain Young's modulus along a is higher
    by 4k. The axis a lies in the plane of bending: φ = 0 points along the finger, φ = 90° from the
    base layer to the bellows. With k below 0 the axis is the soft direction, such as the one in
    which the layers are stacked. Below about −3μ/4 there is no stable material.

    Prior: k = 0 ± 0.3 MPa, which is 14 % of Young's modulus along the raster, and a raster within
    5° of the finger's axis; both are engineering guesses.
    Fingerprint: with the axis along the finger it stiffens the base layer more than the bellows'
    walls, most of which run across. The angle falls by 9 % at 25 kPa and 12 % at 250 kPa, the force
    by 1 % at most. Loading and unloading agree.
    Confused with: base-layer thickness, the modulus.
    """

    either: ClassVar = "stiffer or softer"
    shapeless: ClassVar = ("raster_deg",)

    k_MPa: Annotated[float, Prior(0.0, 0.3, "engineering guess")] = Field(
        0.3, ge=-1000, le=1000, description="of (I4 - 1)²/2; below 0 softer along the axis"
    )
    raster_deg: Annotated[float, Prior(0.0, 5.0, "engineering guess")] = Field(
        0.0, ge=-180, le=180, description="axis, from clamp-to-tip towards the bellows"
    )

    @property
    def shears_bars(self) -> str:
        """The raster's angle, where it is turned."""
        return "raster_deg" if self.raster_deg else ""

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        angle = c["raster_deg"] * (ufl.pi / 180)
        axis = ufl.as_vector([ufl.sin(angle), 0, ufl.cos(angle)])
        return transverse_isotropy.energy(strain, c["k_MPa"], axis)
