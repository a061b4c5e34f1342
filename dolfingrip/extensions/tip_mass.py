"""A mass that is fixed to the tip's face."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar

import ufl
from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Effect, Prior, Setup, Site


class TipMass(Effect):
    """A mass on the tip's face.

    Π −= m g · (u + c ∂u/∂N) of the tip's face with its normal N, and the kinetic energy
    m/2 |u̇ + c ∂u̇/∂N|²: the mass m is spread over the face, moves and turns with it, and its centre
    lies c before it.

    Prior: 10 ± 5 g, as of a marker or a sensor with its cable (engineering guess).
    Fingerprint: sag under gravity; natural frequencies lower by the root of the moving mass.
    Nothing, without weight and at rest.
    Confused with: the density; a lower modulus in motion.
    """

    kind: ClassVar = "set-up"
    felt_by: ClassVar = ("finger",)
    checks: ClassVar = (DirectCheck("weigh what is fixed to the tip", 2.0, {"mass_g": 0.1}),)

    mass_g: Annotated[
        float, Prior(10.0, 5.0, "marker or sensor: engineering guess", positive=True)
    ] = Field(10.0, ge=0, le=1e5, description="mass that is fixed to the tip's face")
    centre_mm: Annotated[float, Prior(0.0, 5.0, "engineering guess")] = Field(
        0.0, ge=-1000, le=1000, description="distance of its centre from the face, outwards"
    )

    @classmethod
    def possible(cls, config: Setup) -> bool:
        """Readings at rest do not tell it from a dead weight.

        Args:
            config: of the body that it acts on.
        """
        return config.experiment.dynamic

    def terms(self, site: Site) -> Sequence[ufl.Form]:
        mass_t = 1e-6 * site.constant(self, "mass_g")
        return [site.fix_mass(mass_t, site.constant(self, "centre_mm"), "tip")]
