"""Gent–Gent law: Gent's, and a logarithm of the second invariant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from dolfingrip.forms.functions import ln
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.laws.gent import limited
from dolfingrip.sections.laws.law import Fittable, MaterialLaw
from dolfingrip.sections.section import Ratio


class GentGent(MaterialLaw):
    """ψ = −μ Jₘ/2 ln(1 − (Ī₁ − 3)/Jₘ) + C₂ ln(Ī₂/3) + K/2 (ln J)².

    μ is the chains' part of the shear modulus and Jₘ the limit of Ī₁ − 3, as in Gent's law. C₂ is
    what entanglements add: the shear modulus at rest is μ + 2/3 C₂, and their part fades as the
    stretch grows (Pucci & Saccomandi, Rubber Chem. Technol. 75, 2002; Ogden, Saccomandi & Sgura,
    Comput. Mech. 34, 2004).
    """

    moduli: ClassVar = ("gg_mu_MPa", "gg_C2_MPa")
    fits: ClassVar = (
        Fittable(
            "gent-gent", "Gent–Gent", ("gg_mu_MPa", "gg_limit", "gg_C2_MPa"),
            lambda shear_MPa: [
                [0.8 * shear_MPa, limit, 0.3 * shear_MPa] for limit in (10.0, 50.0, 200.0)
            ],
            (0.0, 0.1, 0.0), (float("inf"), 1e4, float("inf")), linear=False, fewer="gent",
        ),
    )  # fmt: skip

    gg_mu_MPa: float = Field(1.0, ge=0, description="gent-gent: shear modulus of the chains")
    gg_limit: Ratio = Field(
        50.0, ge=0.1, le=1e4, description="gent-gent: limit Jm of I1 - 3, where chains end"
    )
    gg_C2_MPa: float = Field(0.0, ge=0, description="gent-gent: of ln(I2/3), entanglements")

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        return self.gg_mu_MPa + 2 / 3 * self.gg_C2_MPa

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """Chains and entanglements."""
        second, of_second = invariants.second, c["gg_C2_MPa"]
        i2 = second.f + 3
        entangled = second.through(of_second * ln(i2 / 3), of_second / i2, -of_second / (i2 * i2))
        return limited(invariants.first, c["gg_mu_MPa"], c["gg_limit"]) + entangled
