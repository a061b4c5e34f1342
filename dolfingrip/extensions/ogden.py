"""Another exponent of the principal stretches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Elastic
from dolfingrip.forms import ogden_terms
from dolfingrip.sections.section import Ratio


class OgdenExponent(Elastic):
    """Softening or stiffening by the exponent of the stretches (Ogden, one term).

    ψ += 2μ/α² (λ̄₁ᵅ + λ̄₂ᵅ + λ̄₃ᵅ − 3) − μ/2 (Ī₁ − 3): Ogden's term replaces the neo-Hookean
    one of the same initial modulus (Ogden, Proc. R. Soc. A 326, 1972), which is Ogden's with α = 2.
    See :mod:`dolfingrip.forms.ogden_terms`.

    Prior: α = 1 ± 0.4, an engineering guess; α = 2 is neo-Hooke. The softening of printed
    NinjaFlex asks for the lowest exponents (mooney_rivlin fits it better, with one parameter, too).
    Fingerprint: at low pressure angle and force are the base model's. With α below 2 the angle then
    rises above it, for α = 1 by 2.1 % at 250 kPa, and the force by 0.2 %. With α above 2 they fall.
    Loading and unloading agree, at any rate.
    Confused with: Mooney–Rivlin (both soften), Yeoh's and Gent's energies (both stiffen).
    """

    neutral: ClassVar = {"alpha": 2.0}

    alpha: Annotated[Ratio, Prior(1.0, 0.4, "engineering guess", positive=True)] = Field(
        1.0, ge=0.5, le=2.5, description="exponent of the stretches"
    )

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        return ogden_terms.energy(strain, [mu, -mu], [c["alpha"], 2.0])
