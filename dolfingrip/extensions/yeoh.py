"""Stiffening or softening at large strain: higher powers of the first invariant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Elastic
from dolfingrip.forms import polynomial


class Yeoh(Elastic):
    """Stiffening or softening at large strain (Yeoh).

    ψ += C₂₀ (Ī₁ − 3)² + C₃₀ (Ī₁ − 3)³, added to the base model, whose C₁₀ is μ/2 (Yeoh, Rubber
    Chem. Technol. 66, 1993). See :mod:`dolfingrip.forms.polynomial`.

    Prior: an engineering guess, in the range of soft thermoplastic polyurethane. Printed NinjaFlex
    stiffens only beyond a stretch of 2.5.
    Fingerprint: at low pressure nothing changes. At the highest pressures, where the bellows' walls
    are stretched most, angle and force fall below the base model's, by 1.1 and 0.4 % at 250 kPa.
    Loading and unloading agree.
    Confused with: Gent's and Ogden's energies.
    """

    either: ClassVar = "stiffening or softening"
    neutral: ClassVar = {"C20_MPa": 0.0, "C30_MPa": 0.0}

    C20_MPa: Annotated[float, Prior(0.05, 0.1, "engineering guess")] = Field(
        0.05, ge=-1000, le=1000, description="of (I1 - 3)²; below 0 it softens"
    )
    C30_MPa: Annotated[float, Prior(0.02, 0.02, "engineering guess", positive=True)] = Field(
        0.02, ge=0, le=1000, description="of (I1 - 3)³"
    )

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        return polynomial.energy(strain, {(2, 0): c["C20_MPa"], (3, 0): c["C30_MPa"]})
