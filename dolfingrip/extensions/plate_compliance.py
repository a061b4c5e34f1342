"""A compliant force sensor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar

import ufl
from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior, Site


class PlateCompliance(Effect):
    """A compliant force sensor.

    Π += f (d − d₀) − c f²/2 with the plate's place d along its normal and the spring's force f
    unknowns, d₀ unloaded, and c the compliance: a spring in series with the finger, d₀ − d = c F.
    At c = 0 the plate is fixed.

    Prior: 0.02 ± 0.01 mm/N, load cells having about 50 N/mm; spread an engineering guess.
    Fingerprint: force lower by the share that the finger's stiffness at its tip has of the sensor's
    (0.05 %); the tip moves towards the plate. Free bending is untouched.
    Confused with: the force's gain, compliance of the clamp, a gap.
    """

    kind: ClassVar = "set-up"
    felt_by: ClassVar = ("plate",)

    compliance_mm_per_N: Annotated[
        float, Prior(0.02, 0.01, "load cells, about 50 N/mm; spread an engineering guess", True)
    ] = Field(0.02, ge=0, le=100, description="of the sensor with its plate")

    def terms(self, site: Site) -> Sequence[ufl.Form]:
        if site.plate is None:
            return ()
        place, unloaded = site.plate.offset, site.plate.unloaded
        site.plate.solve_for(site.unknown(self, "place_mm", place))
        compliance = site.constant(self, "compliance_mm_per_N")
        return [site.spring(self, "force_N", place - unloaded, compliance)]
