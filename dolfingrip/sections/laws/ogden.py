"""Ogden's law: powers of the principal stretches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Annotated, Any, ClassVar, Final

from pydantic import Field

from dolfingrip.forms import ogden_terms
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.laws.law import Fittable, MaterialLaw
from dolfingrip.sections.ranges import PURE
from dolfingrip.sections.section import Numbers, Refusal

ALPHA: Final = (0.05, 10.0)
"""Smallest and largest exponent, of either sign."""

EXPONENTS: Final = (0.7, 1.3, 2.0, 3.0, 4.5, 7.0, 9.5, -1.0, -2.0, -3.0, -5.0, -8.0)
"""Exponents that the terms of a fit start from, in all combinations."""


def terms_refused(
    mu_key: str, mu: Sequence[float], alpha_key: str, alpha: Sequence[float]
) -> Iterator[Refusal]:
    """Yield refusals of exponents that are not one for each modulus, or out of :data:`ALPHA`.

    Args:
        mu_key, alpha_key: keys that name them.
        mu, alpha: moduli and exponents.
    """
    if len(alpha) != len(mu):
        yield Refusal(
            alpha_key, f"allowed: as many numbers as {mu_key} has, {len(mu)}", list(alpha)
        )
    low, high = ALPHA
    if not all(low <= abs(exponent) <= high for exponent in alpha):
        yield Refusal(
            alpha_key, f"allowed: each from {low:g} to {high:g}, or below 0 likewise", list(alpha)
        )


def _fit(terms: int) -> Fittable:
    """The law with so many terms."""

    def starts(shear_MPa: float) -> list[list[float]]:
        return [[*[shear_MPa] * terms, *exponents] for exponents in combinations(EXPONENTS, terms)]

    return Fittable(
        f"ogden-{terms}",
        f"Ogden, {terms} term{'s' if terms > 1 else ''}",
        tuple(f"ogden_{key}[{k}]" for key in ("mu_MPa", "alpha") for k in range(terms)),
        starts,
        (0.0,) * terms + (-ALPHA[1],) * terms,
        (float("inf"),) * terms + (ALPHA[1],) * terms,
        (0.0,) * terms + (ALPHA[0],) * terms,
        linear=False,
        fewer=f"ogden-{terms - 1}" if terms > 1 else "",
    )


class Ogden(MaterialLaw):
    """ψ = Σ 2μ/α² (λ̄₁ᵅ + λ̄₂ᵅ + λ̄₃ᵅ − 3) + K/2 (ln J)²; see :mod:`dolfingrip.forms.ogden_terms`."""

    moduli: ClassVar = ("ogden_mu_MPa",)
    fits: ClassVar = tuple(_fit(terms) for terms in (1, 2, 3))

    ogden_mu_MPa: Numbers = Field((), description="ogden: shear moduli of the terms")
    ogden_alpha: Annotated[Numbers, PURE] = Field(
        (), description="ogden: exponents of the stretches"
    )

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        return sum(self.ogden_mu_MPa)

    def refusals(self) -> Iterator[Refusal]:
        """Yield refusals of no terms, and of terms without an exponent of their own."""
        if not self.ogden_mu_MPa:
            yield Refusal("ogden_mu_MPa", 'allowed: a list of numbers with law = "ogden"')
        yield from terms_refused("ogden_mu_MPa", self.ogden_mu_MPa, "ogden_alpha", self.ogden_alpha)

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """The sum of the terms."""
        mu, alpha = c["ogden_mu_MPa"], c["ogden_alpha"]
        terms = range(len(alpha))
        return ogden_terms.of_powers(invariants, [mu[k] for k in terms], [alpha[k] for k in terms])
