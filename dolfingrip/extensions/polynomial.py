"""Further powers of the invariants in the strain energy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Elastic
from dolfingrip.sections.laws.polynomial import POWERS, InvariantPolynomial

GUESS = "engineering guess"
Factor = Annotated[float, Field(ge=-1000, le=1000)]


class PolynomialTerms(Elastic):
    """A polynomial of the invariants added to the base model's energy.

    ψ += Σ C_ij (Ī₁ − 3)ⁱ (Ī₂ − 3)ʲ (Rivlin & Saunders, Phil. Trans. R. Soc. A 243, 1951). The
    initial shear modulus rises by 2 (C₁₀ + C₀₁). See :mod:`dolfingrip.forms.polynomial`;
    ``material.law = "polynomial"`` has such terms alone.

    Prior: engineering guesses, in the range of soft thermoplastic polyurethane.
    Fingerprint: angle and force are lower at all pressures, by 5.9 and 0.3 % at 25 kPa and by
    6.7 and 3.3 % at 250 kPa. Loading and unloading agree, at any rate.
    Confused with: the modulus at low pressure; Mooney–Rivlin, Yeoh's and Ogden's energies.
    """

    neutral: ClassVar = dict.fromkeys(POWERS, 0.0)

    C10_MPa: Annotated[Factor, Prior(0.0, 0.3, GUESS)] = Field(0.0, description="of (I1 - 3)")
    C01_MPa: Annotated[Factor, Prior(0.1, 0.3, GUESS)] = Field(0.1, description="of (I2 - 3)")
    C20_MPa: Annotated[Factor, Prior(0.0, 0.1, GUESS)] = Field(0.0, description="of (I1 - 3)²")
    C11_MPa: Annotated[Factor, Prior(0.02, 0.05, GUESS)] = Field(
        0.02, description="of (I1 - 3)(I2 - 3)"
    )
    C02_MPa: Annotated[Factor, Prior(0.0, 0.05, GUESS)] = Field(0.0, description="of (I2 - 3)²")
    C30_MPa: Annotated[Factor, Prior(0.0, 0.02, GUESS)] = Field(0.0, description="of (I1 - 3)³")

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        return InvariantPolynomial.of_shape(strain, c)
