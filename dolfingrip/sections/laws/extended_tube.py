"""Extended tube: chains of a limited length in tubes of their neighbours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from dolfingrip.forms.functions import ln, remaining
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.laws.law import Fittable, MaterialLaw
from dolfingrip.sections.section import Ratio


class ExtendedTube(MaterialLaw):
    """ψ = G_c/2 [(1 − δ²)D/(1 − δ²D) + ln(1 − δ²D)] + 2G_e/β² Σ (λ̄ᵢ^(−β) − 1),   D = Ī₁ − 3.

    G_c is the modulus of the network's links and G_e that of its entanglements; the shear modulus
    at rest is G_c (1 − 2δ²) + G_e. δ tells how soon chains end (at Ī₁ − 3 = 1/δ²), and β how freely
    tubes give way as they are stretched (Kaliske & Heinrich, Rubber Chem. Technol. 72, 1999).
    """

    moduli: ClassVar = ("tube_Gc_MPa", "tube_Ge_MPa")
    fits: ClassVar = (
        Fittable(
            "extended-tube", "extended tube",
            ("tube_Gc_MPa", "tube_Ge_MPa", "tube_delta", "tube_beta"),
            lambda shear_MPa: [
                [0.6 * shear_MPa, 0.4 * shear_MPa, delta, beta]
                for delta in (0.05, 0.15) for beta in (0.3, 1.0)
            ],
            (0.0, 0.0, 0.0, 0.05), (float("inf"), float("inf"), 0.6, 2.0), linear=False,
        ),
    )  # fmt: skip

    tube_Gc_MPa: float = Field(1.0, ge=0, description="extended-tube: modulus of links")
    tube_Ge_MPa: float = Field(0.0, ge=0, description="extended-tube: modulus of entanglements")
    tube_delta: Ratio = Field(0.0, ge=0, le=0.6, description="extended-tube: chains end at 1/δ²")
    tube_beta: Ratio = Field(
        1.0, ge=0.05, le=2, description="extended-tube: how freely tubes give way"
    )

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        return self.tube_Gc_MPa * (1 - 2 * self.tube_delta**2) + self.tube_Ge_MPa

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """Links, and tubes."""
        linked, tubes, beta = c["tube_Gc_MPa"], c["tube_Ge_MPa"], c["tube_beta"]
        first, square = invariants.first, c["tube_delta"] * c["tube_delta"]
        r = remaining(square * first.f)
        # of (1 − δ²)D/r + ln r with r = 1 − δ²D: r' = −δ²
        links = first.through(
            linked / 2 * ((1 - square) * first.f / r + ln(r)),
            linked / 2 * ((1 - square) / r**2 - square / r),
            linked / 2 * square * (2 * (1 - square) / r**3 - square / r**2),
        )
        return links + invariants.power_sum(-beta) * (2 * tubes / (beta * beta))
