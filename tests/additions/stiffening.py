"""A made-up law of the base material: ψ = μ/2 (i + c i²), i = Ī₁ − 3."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.laws.law import Fittable, MaterialLaw
from dolfingrip.sections.section import Ratio


class Stiffening(MaterialLaw):
    """ψ = μ/2 (i + c i²) + K/2 (ln J)²."""

    moduli: ClassVar = ("stiffening_mu_MPa",)
    fits: ClassVar = (
        Fittable(
            "stiffening",
            "Stiffening",
            ("stiffening_mu_MPa", "stiffening_c"),
            lambda shear_MPa: [[shear_MPa, 0.0]],
            linear=False,
        ),
    )

    stiffening_mu_MPa: float = Field(1.0, gt=0, description="stiffening: shear modulus")
    stiffening_c: Ratio = Field(0.1, ge=-1, le=10, description="stiffening: factor of the square")

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        return self.stiffening_mu_MPa

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """The energy."""
        i = invariants.first
        return (i + (i * i) * c["stiffening_c"]) * (c["stiffening_mu_MPa"] / 2)
