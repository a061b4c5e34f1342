"""Neo-Hooke's law, which the default material has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.forms import neo_hookean
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.laws.law import Fittable, MaterialLaw


class NeoHooke(MaterialLaw):
    """ψ = μ/2 (I₁ − 3 − 2 ln J) + λ/2 (ln J)²; see :mod:`dolfingrip.forms.neo_hookean`."""

    moduli: ClassVar = ("mu_MPa",)
    shear_name: ClassVar = "mu_MPa"
    fits: ClassVar = (
        Fittable("neo-hooke", "neo-Hooke", ("mu_MPa",), lambda shear_MPa: [[shear_MPa]], (0.0,)),
    )

    mu_MPa: float = Field(2.93, gt=0, description="neo-hooke: shear modulus (printed NinjaFlex)")

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        return self.mu_MPa

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """μ/2 (Ī₁ − 3): what is left at constant volume."""
        return invariants.first * (c["mu_MPa"] / 2)

    @classmethod
    def of_shape(cls, strain: Expr, c: Mapping[str, Expr]) -> Expr:
        """The energy of I₁ itself, whose change of volume λ alone resists."""
        return neo_hookean.energy(strain, c["mu_MPa"], 0.0)

    @classmethod
    def volumetric(cls, mu: Expr, lmbda: Expr) -> Expr:
        """λ."""
        return lmbda
