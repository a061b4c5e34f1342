"""Arruda–Boyce law: eight chains of a limited length."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Final

from pydantic import Field

from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet, constant, series
from dolfingrip.sections.laws.law import Fittable, MaterialLaw
from dolfingrip.sections.section import Ratio

SERIES: Final = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
"""Factors of Ī₁ᵏ − 3ᵏ over λₘ^(2k−2): the inverse Langevin function's series."""


class ArrudaBoyce(MaterialLaw):
    """ψ = μ Σ aₖ (Ī₁ᵏ − 3ᵏ)/λₘ^(2k−2) + K/2 (ln J)², five terms of the inverse Langevin function.

    μ is n k T of the chains' density n. λₘ is the stretch of a chain at its full length, which
    begins to stiffen at about half of it (Arruda & Boyce, J. Mech. Phys. Solids 41, 1993). The
    shear modulus at rest is μ (1 + 3/(5 λₘ²) + 99/(175 λₘ⁴) + …).
    """

    moduli: ClassVar = ("ab_mu_MPa",)
    fits: ClassVar = (
        Fittable(
            "arruda-boyce", "Arruda–Boyce", ("ab_mu_MPa", "ab_lock"),
            lambda shear_MPa: [[shear_MPa, lock] for lock in (1.5, 3.0, 6.0)],
            (0.0, 1.05), (float("inf"), 100.0), linear=False,
        ),
    )  # fmt: skip

    ab_mu_MPa: float = Field(1.0, gt=0, description="arruda-boyce: n k T of the chains")
    ab_lock: Ratio = Field(
        3.0, ge=1.05, le=100, description="arruda-boyce: a chain's stretch at its full length"
    )

    @property
    def shear_MPa(self) -> float:
        """Initial shear modulus."""
        factors = enumerate(SERIES, start=1)
        return self.ab_mu_MPa * sum(
            2 * a * k * 3 ** (k - 1) / self.ab_lock ** (2 * k - 2) for k, a in factors
        )

    @classmethod
    def energy(cls, c: Mapping[str, Any], invariants: Invariants) -> Jet:
        """The series, less its value at rest."""
        mu, inverse = c["ab_mu_MPa"], 1 / (c["ab_lock"] * c["ab_lock"])
        terms = {(k + 1, 0): mu * a * inverse**k for k, a in enumerate(SERIES)}
        at_rest = sum(factor * 3**k for (k, _), factor in terms.items())
        first = invariants.first + 3
        return series(terms, first, constant(0.0)) + -1 * at_rest
