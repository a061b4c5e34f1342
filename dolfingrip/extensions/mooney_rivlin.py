"""Softening at moderate strain: the second invariant in the strain energy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Elastic
from dolfingrip.forms import polynomial


class MooneyRivlin(Elastic):
    """Softening at moderate strain (Mooney–Rivlin).

    ψ += C₀₁ [(Ī₂ − 3) − (Ī₁ − 3)], the Mooney–Rivlin energy less neo-Hooke. The initial shear
    modulus stays ``material.mu_MPa``, so C₁₀ = μ/2 − C₀₁ (Rivlin & Saunders, Phil. Trans. R. Soc.
    A 243, 1951). See :mod:`dolfingrip.forms.polynomial`.

    Prior: the nominal stresses of eight printed NinjaFlex coupons from 2 to 100 % strain fit
    2 C₀₁/μ = 0.93, which is 1.36 MPa at the default modulus. The spread is an engineering guess.
    Fingerprint: at low pressure angle and force are the base model's. As the walls stretch, the
    angle rises above the base model's, by 4.1 % at 250 kPa; the force hardly changes (−0.5 %).
    Loading and unloading agree, at any rate.
    Confused with: a smaller modulus or thinner walls, if there are readings at one pressure only;
    Mullins softening, which unloads on another curve.
    """

    curved: ClassVar = True

    C01_MPa: Annotated[
        float,
        Prior(1.36, 0.4, "printed NinjaFlex coupons; spread an engineering guess", positive=True),
    ] = Field(1.36, ge=0, le=1000, description="C01 at a fixed initial shear modulus")

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        return polynomial.energy(strain, {(0, 1): c["C01_MPa"], (1, 0): -c["C01_MPa"]})
