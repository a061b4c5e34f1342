"""More powers of the principal stretches, of either sign."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Elastic
from dolfingrip.forms import ogden_terms
from dolfingrip.sections.laws.ogden import ALPHA, terms_refused
from dolfingrip.sections.ranges import PURE
from dolfingrip.sections.section import Refusal

Terms = Annotated[tuple[float, ...], Field(strict=False, min_length=1, max_length=3)]


class OgdenTerms(Elastic):
    """Terms of Ogden's energy added to the base model's, such as a biaxial stiffening.

    ψ += Σ 2μ_k/α_k² (λ̄₁^α_k + λ̄₂^α_k + λ̄₃^α_k − 3) (Ogden, Proc. R. Soc. A 326, 1972). The
    initial shear modulus rises by Σ μ_k. A term with a negative exponent hardly acts in uniaxial
    tension and much in equibiaxial tension, which governs ballooning. See
    :mod:`dolfingrip.forms.ogden_terms`; ``material.law = "ogden"`` has such terms alone.

    Prior: μ = 0.2 ± 0.2 MPa and α = −3 ± 1.5, engineering guesses.
    Fingerprint: angle and force are lower at all pressures, by 5.9 and 0.3 % at 25 kPa and by
    6.5 and 3.2 % at 250 kPa. Loading and unloading agree, at any rate.
    Confused with: the modulus at low pressure; Mooney–Rivlin and Yeoh's energies.
    """

    neutral: ClassVar = {"mu_MPa": [0.0]}

    mu_MPa: Annotated[Terms, Prior(0.2, 0.2, "engineering guess")] = Field(
        (0.2,), description="shear modulus of each term; of either sign"
    )
    alpha: Annotated[Terms, PURE, Prior(-3.0, 1.5, "engineering guess", least=ALPHA[0])] = Field(
        (-3.0,), description="exponent of the stretches of each term; not 0"
    )

    def refusals(self) -> Iterator[Refusal]:
        """Yield refusals of terms without an exponent of their own."""
        return terms_refused("mu_MPa", self.mu_MPa, "alpha", self.alpha)

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        terms = range(len(self.alpha))
        mu_MPa, alpha = ([c[key][k] for k in terms] for key in ("mu_MPa", "alpha"))
        return ogden_terms.energy(strain, mu_MPa, alpha)
