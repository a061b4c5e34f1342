"""Stiffening at large strain: chains of a limited length."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.kinds import Elastic
from dolfingrip.forms import gent
from dolfingrip.sections.section import Ratio


class Gent(Elastic):
    """Stiffening at large strain (Gent).

    ψ += −μ/2 [Jₘ ln(1 − x) + Ī₁ − 3], x = (Ī₁ − 3)/Jₘ, Gent's energy less neo-Hooke
    (Gent, Rubber Chem. Technol. 69, 1996). The parameter is 1/Jₘ; at 0 the chains have no limit.
    A state with x ≥ 1 does not exist, and a load step that would go there fails. See
    :mod:`dolfingrip.forms.gent`.

    Prior: Jₘ = 40 ± 20, an engineering guess: printed NinjaFlex stiffens beyond a stretch of 2.5
    and breaks at some 6 to 7, where Ī₁ − 3 is 33 to 46. To first order 1/Jₘ is 1/40 ± 20/40².
    Fingerprint: at low pressure nothing changes. At the highest pressures, where the bellows' walls
    are stretched most, angle and force fall below the base model's, by 0.4 and 0.1 % at 250 kPa.
    Loading and unloading agree.
    Confused with: Yeoh's and Ogden's energies.
    """

    inverse_J_m: Annotated[Ratio, Prior(0.025, 0.0125, "engineering guess", positive=True)] = Field(
        0.025, ge=0, le=10, description="1 by the limit of I1 - 3"
    )

    def added(self, strain: Expr, mu: Expr, c: Mapping[str, Any]) -> Expr:
        return gent.energy(strain, mu, c["inverse_J_m"])
