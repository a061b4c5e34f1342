"""More powers of the principal stretches, of either sign."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field, model_validator
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Prior, StrainEnergy
from dolfingrip.forms import ogden_terms
from dolfingrip.sections.laws.ogden import ALPHA, check_terms

if TYPE_CHECKING:
    from dolfingrip.extensions.site import Site

Terms = Annotated[tuple[float, ...], Field(strict=False, min_length=1, max_length=3)]


class OgdenTerms(Effect):
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

    kind: ClassVar = "elastic"
    neutral: ClassVar = {"mu_MPa": [0.0]}

    mu_MPa: Annotated[Terms, Prior(0.2, 0.2, "engineering guess")] = Field(
        (0.2,), description="shear modulus of each term; of either sign"
    )
    alpha: Annotated[Terms, Prior(-3.0, 1.5, "engineering guess", least=ALPHA[0])] = Field(
        (-3.0,), description="exponent of the stretches of each term; not 0"
    )

    @model_validator(mode="after")
    def _terms(self) -> OgdenTerms:
        check_terms("mu_MPa", self.mu_MPa, "alpha", self.alpha)
        return self

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        mu, alpha = site.constant(self, "mu_MPa"), site.constant(self, "alpha")
        terms = range(len(self.alpha))

        def density(strain: Expr) -> Expr:
            more = ogden_terms.energy(strain, [mu[k] for k in terms], [alpha[k] for k in terms])
            return base(strain) + more

        return density
