"""A new law of rubber: written down once, fitted to a coupon, and compared with neo-Hooke's.

Lopez-Pamies' law (C. R. Mécanique 338, 2010) is

    ψ = 3^(1−α)/(2α) μ (I₁^α − 3^α),

neo-Hooke's for α = 1. At constant volume I₁ = λ² + 2/λ in a bar of stretch λ, and its nominal
stress is P = dψ/dλ = 3^(1−α) I₁^(α−1) μ (λ − λ⁻²).

A law of the package is a class with its keys and its energy as a function of the invariants. The
energy is a ``Jet``: a value with its derivatives by Ī₁ and Ī₂. With numbers it serves a fit, with
UFL's expressions the solver. As a file in ``dolfingrip/sections/laws/`` this class would also be a
``material.law`` (docs/add_material.md); here it is fitted alone.

    scripts/run python examples/new_material.py
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from dolfingrip.experiments.material_fit import coupons
from dolfingrip.experiments.material_fit.fit import LawFit, fit
from dolfingrip.experiments.material_fit.law import LAWS, Law, stress
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections.laws.law import Fittable, MaterialLaw
from dolfingrip.sections.section import Ratio

COUPON = Path(__file__).with_name("coupons") / "ecoflex30_uniaxial.csv"
MAX_STRETCH = 4.0


class LopezPamies(MaterialLaw):
    """ψ = 3^(1−α)/(2α) μ (I₁^α − 3^α)."""

    moduli: ClassVar = ("lopez_mu_MPa",)
    fits: ClassVar = (
        Fittable(
            "lopez-pamies",
            "Lopez-Pamies",
            ("lopez_mu_MPa", "lopez_alpha"),
            lambda shear_MPa: [[shear_MPa, 1.2]],
            low=(0.0, 0.3),
            high=(np.inf, 8.0),
            linear=False,
        ),
    )

    lopez_mu_MPa: float = Field(1.0, gt=0, description="shear modulus")
    lopez_alpha: Ratio = Field(1.2, gt=0.3, description="exponent of I₁")

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        return self.lopez_mu_MPa

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """The energy with its first and second derivatives by Ī₁; ``first`` is Ī₁ − 3."""
        mu, alpha = c["lopez_mu_MPa"], c["lopez_alpha"]
        first = invariants.first.f + 3
        factor = 3 ** (1 - alpha) * mu / 2
        return invariants.first.through(
            factor / alpha * (first**alpha - 3**alpha),
            factor * first ** (alpha - 1),
            factor * (alpha - 1) * first ** (alpha - 2),
        )


class Found(NamedTuple):
    """Results of the example.

    Attributes:
        new, neo_hooke: fits to the coupon.
        stress_MPa: nominal stress of the new law at a stretch of 2.
    """

    new: LawFit
    neo_hooke: LawFit
    stress_MPa: float


def main() -> Found:
    """Fit both laws to the readings up to a stretch of 4."""
    data = coupons.read(COUPON, MAX_STRETCH)
    (fittable,) = LopezPamies.fits
    law = Law(fittable, LopezPamies)
    new = fit(law, data)
    at_two = stress(law, "uniaxial", np.array([2.0]), new.values)
    return Found(new, fit(LAWS["neo-hooke"], data), float(at_two[0]))


if __name__ == "__main__":
    found = main()
    mu, alpha = found.new.values
    print(f"Lopez-Pamies: μ = {mu:.4f} MPa, α = {alpha:.3f}, rms {found.new.relative_rms:.1%}")
    other = found.neo_hooke
    print(f"neo-Hooke: μ = {other.values[0]:.4f} MPa, rms {other.relative_rms:.1%}")
