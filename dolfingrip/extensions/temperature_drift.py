"""A material that warms up and softens."""

from __future__ import annotations

from typing import Annotated, ClassVar

import ufl
from pydantic import Field
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Prior, Site, StrainEnergy


class TemperatureDrift(Effect):
    """A modulus that drifts with the temperature.

    ψ ← (1 + c θ) ψ, θ = ΔT (1 − exp(−t/τ)), where θ is the warming since the start. All moduli
    change alike.

    Prior: c = −0.0075 ± 0.0025 1/°C: thermoplastic polyurethane loses 0.5 to 1 % per °C. A
    laboratory that drifts by 0 ± 2 °C over 1000 ± 1000 s is an engineering guess.
    Fingerprint: angle and force change by a factor that creeps with time, cycle after cycle,
    whatever the pressure does. Loading and unloading differ by the time between them (0.2 % of the
    angle after 125 s).
    Confused with: viscoelasticity and Mullins softening, which depend on the loading before; the
    force's drift, which does not change the angle.
    """

    kind: ClassVar = "loading"
    neutral: ClassVar = {"warming_degC": 0.0}
    shapeless: ClassVar = ("modulus_per_degC",)
    # on three cycles warming of any τ has a cosine of 0.996 and more with any other
    alike: ClassVar = ("tau_s",)
    clock: ClassVar = True

    modulus_per_degC: Annotated[
        float, Prior(-0.0075, 0.0025, "thermoplastic polyurethane, -0.5 to -1 % per °C")
    ] = Field(-0.0075, ge=-0.1, le=0.1, description="relative change of the moduli")
    warming_degC: Annotated[float, Prior(0.0, 2.0, "engineering guess")] = Field(
        2.0, ge=-9, le=9, description="in the end, since the start"
    )
    tau_s: Annotated[float, Prior(1000.0, 1000.0, "engineering guess", positive=True)] = Field(
        1000.0, gt=0, le=1e7, description="time constant of warming"
    )

    def strain_energy(self, base: StrainEnergy, site: Site) -> StrainEnergy:
        keys = ("modulus_per_degC", "warming_degC", "tau_s")
        slope, warming, tau = (site.constant(self, key) for key in keys)
        factor = 1 + slope * warming * (1 - ufl.exp(-site.time_s / tau))

        def density(strain: Expr) -> Expr:
            return factor * base(strain)

        return density
