"""Stiffer or softer along one direction of the print."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

import ufl
from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Prior, StrainEnergy
from dolfingrip.forms import transverse_isotropy

if TYPE_CHECKING:
    from dolfingrip.extensions.site import Site


class PrintAnisotropy(Effect):
    """Transverse isotropy: stiffer along the raster, or softer across the layers.

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

    kind: ClassVar = "elastic"
    neutral: ClassVar = {"k_MPa": 0.0}
    shapeless: ClassVar = ("raster_deg",)

    k_MPa: Annotated[float, Prior(0.0, 0.3, "engineering guess")] = Field(
        0.3, ge=-1000, le=1000, description="of (I4 - 1)²/2; below 0 softer along the axis"
    )
    raster_deg: Annotated[float, Prior(0.0, 5.0, "engineering guess")] = Field(
        0.0, ge=-180, le=180, description="axis, from clamp-to-tip towards the bellows"
    )

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        k, degrees = site.constant(self, "k_MPa"), site.constant(self, "raster_deg")
        angle = degrees * (ufl.pi / 180)
        axis = ufl.as_vector([ufl.sin(angle), 0, ufl.cos(angle)])

        def density(strain: Expr) -> Expr:
            return base(strain) + transverse_isotropy.energy(strain, k, axis)

        return density
