"""Stiffening at large strain: higher powers of the first invariant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Prior, StrainEnergy
from dolfingrip.forms import polynomial

if TYPE_CHECKING:
    from dolfingrip.extensions.site import Site


class Yeoh(Effect):
    """Stiffening at large strain (Yeoh).

    ψ += C₂₀ (Ī₁ − 3)² + C₃₀ (Ī₁ − 3)³, added to the base model, whose C₁₀ is μ/2 (Yeoh, Rubber
    Chem. Technol. 66, 1993). See :mod:`dolfingrip.forms.polynomial`.

    Prior: an engineering guess, in the range of soft thermoplastic polyurethane. Printed NinjaFlex
    stiffens only beyond a stretch of 2.5.
    Fingerprint: at low pressure nothing changes. At the highest pressures, where the bellows' walls
    are stretched most, angle and force fall below the base model's, by 1.1 and 0.4 % at 250 kPa.
    Loading and unloading agree.
    Confused with: Gent's and Ogden's energies.
    """

    kind: ClassVar = "elastic"
    neutral: ClassVar = {"C20_MPa": 0.0, "C30_MPa": 0.0}

    C20_MPa: Annotated[float, Prior(0.05, 0.1, "engineering guess")] = Field(
        0.05, ge=-1000, le=1000, description="of (I1 - 3)²; below 0 it softens"
    )
    C30_MPa: Annotated[float, Prior(0.02, 0.02, "engineering guess", positive=True)] = Field(
        0.02, ge=0, le=1000, description="of (I1 - 3)³"
    )

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        c20, c30 = site.constant(self, "C20_MPa"), site.constant(self, "C30_MPa")

        def density(strain: Expr) -> Expr:
            return base(strain) + polynomial.energy(strain, {(2, 0): c20, (3, 0): c30})

        return density
