"""Gent's law: chains of a limited length."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from dolfingrip.forms.functions import ln, remaining
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.laws.law import Fittable, MaterialLaw
from dolfingrip.sections.section import Ratio


def limited(first: Jet, mu: Any, limit: Any) -> Jet:
    """ψ = −μ Jₘ/2 ln(1 − (Ī₁ − 3)/Jₘ), which is unbounded at Ī₁ − 3 = Jₘ.

    Args:
        first: Ī₁ − 3.
        mu: shear modulus μ (MPa).
        limit: Jₘ.
    """
    rest = remaining(first.f / limit)
    return first.through(-mu * limit / 2 * ln(rest), mu / 2 / rest, mu / 2 / (limit * rest * rest))


class GentLaw(MaterialLaw):
    """ψ = −μ Jₘ/2 ln(1 − (Ī₁ − 3)/Jₘ) + K/2 (ln J)².

    μ is the shear modulus at rest. Jₘ is the value of Ī₁ − 3 at which the chains are at their full
    length; a silicone has 10 to 100, a stiff filament 1 to 10 (Gent, Rubber Chem. Technol. 69,
    1996).
    """

    moduli: ClassVar = ("gent_mu_MPa",)
    shear_name: ClassVar = "gent_mu_MPa"
    fits: ClassVar = (
        Fittable(
            "gent", "Gent", ("gent_mu_MPa", "gent_limit"),
            lambda shear_MPa: [[shear_MPa, limit] for limit in (10.0, 50.0, 200.0)],
            (0.0, 0.1), (float("inf"), 1e4), linear=False,
        ),
    )  # fmt: skip

    gent_mu_MPa: float = Field(1.0, gt=0, description="gent: shear modulus at rest")
    gent_limit: Ratio = Field(
        50.0, ge=0.1, le=1e4, description="gent: limit Jm of I1 - 3, where chains end"
    )

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        return self.gent_mu_MPa

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """The logarithm of what is left of the chains' length."""
        return limited(invariants.first, c["gent_mu_MPa"], c["gent_limit"])
