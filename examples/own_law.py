"""A law of your own: Demiray's exponential of the first invariant, in a file of your own.

    dolfingrip bend --plugin examples/own_law.py -s material.law=own-law --pressure 100 --render 100

The energy alone is written down (Demiray, J. Biomech. 5, 1972); stress and tangent follow.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from dolfingrip.forms.functions import exp
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.laws.law import MaterialLaw
from dolfingrip.sections.section import Ratio


class OwnLaw(MaterialLaw):
    """ψ = μ/(2b) (exp(b (Ī₁ − 3)) − 1) + K/2 (ln J)²."""

    moduli: ClassVar = ("own_mu_MPa",)

    own_mu_MPa: float = Field(1.0, gt=0, description="own-law: shear modulus at rest")
    own_b: Ratio = Field(0.1, gt=0, le=10, description="own-law: how soon it stiffens")

    @property
    def shear_MPa(self) -> float:
        return self.own_mu_MPa

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        mu, b = c["own_mu_MPa"], c["own_b"]
        return mu / (2 * b) * (exp(b * invariants.first) - 1)  # first is Ī₁ − 3
