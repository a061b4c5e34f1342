"""A polynomial of the invariants: Mooney–Rivlin's law, Yeoh's and others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Final

from pydantic import Field

from dolfingrip.forms import polynomial
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.laws.law import Fittable, MaterialLaw
from dolfingrip.sections.section import Refusal

POWERS: Final = {"C10_MPa": (1, 0), "C01_MPa": (0, 1), "C20_MPa": (2, 0), "C11_MPa": (1, 1),
                 "C02_MPa": (0, 2), "C30_MPa": (3, 0)}  # fmt: skip
"""Exponents of Ī₁ − 3 and Ī₂ − 3 by the keys of their factors."""


def _fit(name: str, title: str, fewer: str, factors: str) -> Fittable:
    """The law with these factors, C10 first."""
    keys = tuple(f"{factor}_MPa" for factor in factors.split())
    start = [0.0] * (len(keys) - 1)
    return Fittable(name, title, keys, lambda shear: [[shear / 2, *start]], fewer=fewer)


class InvariantPolynomial(MaterialLaw):
    """ψ = Σ C_ij (Ī₁ − 3)ⁱ (Ī₂ − 3)ʲ + K/2 (ln J)²; see :mod:`dolfingrip.forms.polynomial`.

    Biderman's polynomial (1958), which is fitted, has the first invariant to the third power and
    the second to the first.
    """

    moduli: ClassVar = tuple(POWERS)
    fits: ClassVar = (
        _fit("mooney-rivlin", "Mooney–Rivlin", "neo-hooke", "C10 C01"),
        _fit("yeoh", "Yeoh", "neo-hooke", "C10 C20 C30"),
        _fit("polynomial", "polynomial (Biderman)", "yeoh", "C10 C01 C20 C30"),
    )

    C10_MPa: float | None = Field(None, description="polynomial: of (I1 - 3)")
    C01_MPa: float | None = Field(None, description="polynomial: of (I2 - 3)")
    C20_MPa: float | None = Field(None, description="polynomial: of (I1 - 3)²")
    C11_MPa: float | None = Field(None, description="polynomial: of (I1 - 3)(I2 - 3)")
    C02_MPa: float | None = Field(None, description="polynomial: of (I2 - 3)²")
    C30_MPa: float | None = Field(None, description="polynomial: of (I1 - 3)³")

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        return 2 * ((self.C10_MPa or 0.0) + (self.C01_MPa or 0.0))

    def refusals(self) -> Iterator[Refusal]:
        """Yield a refusal of a polynomial without factors."""
        if all(getattr(self, key) is None for key in POWERS):
            yield Refusal("C10_MPa", 'allowed: a number with law = "polynomial"')

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """The polynomial."""
        return polynomial.of_invariants(invariants, {POWERS[key]: c[key] for key in c})
