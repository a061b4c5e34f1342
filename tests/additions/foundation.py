"""The documented example of an effect: not part of the package, so outside its index."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import ufl
from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior

if TYPE_CHECKING:
    from dolfingrip.extensions.site import Site


class Foundation(Effect):
    """A soft mat under the base layer's back.

    Π += ∫ k/2 |u|² dA over the skin.

    Prior: 0.001 ± 0.001 N/mm³ (an example).
    Fingerprint: smaller angle at all pressures.
    Confused with: the modulus.
    """

    kind: ClassVar = "set-up"
    neutral: ClassVar = {"k_N_per_mm3": 0.0}

    k_N_per_mm3: Annotated[float, Prior(1e-3, 1e-3, "an example", positive=True)] = Field(
        1e-3, ge=0, description="stiffness per area"
    )

    def terms(self, site: Site) -> Sequence[ufl.Form]:
        k = site.constant(self, "k_N_per_mm3")
        skin = site.domain.surface("skin", quadrature_degree=2)
        return [k / 2 * ufl.inner(site.u, site.u) * skin]
