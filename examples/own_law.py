"""A law of your own: Demiray's exponential of the first invariant, in a file of your own.

    dolfingrip bend --plugin examples/own_law.py --set material.law=own-law

The energy alone is written down; stress and tangent are its derivatives, which UFL takes
(Demiray, J. Biomech. 5, 1972).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import ufl
from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.forms.invariants import isochoric
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
    def of_shape(cls, strain: Expr, c: Mapping[str, Expr]) -> Expr:
        first, _ = isochoric(strain)  # Ī₁ − 3
        return c["own_mu_MPa"] / (2 * c["own_b"]) * (ufl.exp(c["own_b"] * first) - 1)
