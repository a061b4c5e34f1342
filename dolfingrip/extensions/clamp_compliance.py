"""A clamp that gives way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import ufl
from pydantic import Field

from dolfingrip.extensions.effect import Effect, Prior

if TYPE_CHECKING:
    from dolfingrip.extensions.site import Site

TIE_N_PER_MM3 = 1e5
"""What ties the clamped face to its base: it gives way by 1e-5 mm per MPa."""


class ClampCompliance(Effect):
    """A clamp that gives way: a rigid base on springs.

    Π += (s_x² + s_z²)/(2c) + φ²/(2c_φ) + ∫ K/2 |u − s − φ e_y × (X − X_c)|² dA, the base's shift s
    and small turn φ about y being unknowns; the last ties the clamped face to it.

    Prior: c = 0.01 ± 0.01 mm/N and c_φ = (2 ± 2)e-5 rad/(N mm), a printed bracket (engineering
    guess).
    Fingerprint: force lower by the share that the finger's stiffness at its tip has of the clamp's,
    0.4 to 0.6 %; the angle against the plate lower. Free bending of a weightless finger does not
    feel it.
    Confused with: the sensor's compliance, the plate's gap.
    """

    kind: ClassVar = "set-up"
    neutral: ClassVar = {"compliance_mm_per_N": 0.0, "compliance_rad_per_Nmm": 0.0}

    compliance_mm_per_N: Annotated[float, Prior(0.01, 0.01, "engineering guess", positive=True)] = (
        Field(0.01, ge=0, le=100, description="shift of the base by force")
    )
    compliance_rad_per_Nmm: Annotated[
        float, Prior(2e-5, 2e-5, "engineering guess", positive=True)
    ] = Field(2e-5, ge=0, le=0.1, description="turn of the base by moment")

    def terms(self, site: Site) -> Sequence[ufl.Form]:
        shift, turn = self.compliance_mm_per_N, self.compliance_rad_per_Nmm
        if shift == turn == 0:
            return ()
        site.held[0].remove("clamp")
        site.held[2].remove("clamp")
        energy, moved_x, moved_z = 0, 0, 0
        if shift:
            moved_x, moved_z = (site.unknown(self, f"shift_{axis}_mm") for axis in "xz")
            compliance = site.constant(self, "compliance_mm_per_N")
            energy += (moved_x**2 + moved_z**2) / (2 * compliance)
        if turn:
            angle = site.unknown(self, "turn_rad")
            compliance = site.constant(self, "compliance_rad_per_Nmm")
            energy += angle**2 / (2 * compliance)
            arm = ufl.SpatialCoordinate(site.domain.mesh)
            centre = site.centre("clamp")
            moved_x += angle * (arm[2] - centre[2])
            moved_z += -angle * (arm[0] - centre[0])
        away = (site.u[0] - moved_x) ** 2 + (site.u[2] - moved_z) ** 2
        clamp = site.domain.surface("clamp", quadrature_degree=4)
        return [site.lumped(energy), site.fixed(TIE_N_PER_MM3) / 2 * away * clamp]
