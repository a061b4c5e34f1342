"""A body that is heavier or lighter than configured."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import DirectCheck, Effect, FittedKey, LabNumber, Prior, Setup
from dolfingrip.sections.section import FINGERS, Ratio


class BodyDensity(Effect):
    """A body that is heavier or lighter than configured.

    ρ ← c ρ of the body's material, in weight and inertia.

    Prior: 1 ± 0.03, a data sheet's density and the air in a print or a cast (engineering guess). A
    balance tells it: whatever lags is no reason for a density that a balance would not show.
    Fingerprint: all natural frequencies by 1/√c, all ratios of swings alike; nothing in slow ramps.
    Confused with: a modulus, where only frequencies are read; a mass on the tip.
    """

    kind: ClassVar = "set-up"
    felt_by: ClassVar = FINGERS
    neutral: ClassVar = {"factor": 1.0}
    either: ClassVar = "heavier or lighter"
    told: ClassVar = LabNumber("density", 0.03, "relative, of the body's material")
    checks: ClassVar = (DirectCheck("weigh the body", 2.0, {"factor": 0.01}),)

    factor: Annotated[Ratio, Prior(1.0, 0.03, "data sheets and air in the material")] = Field(
        1.1, gt=0, le=100, description="true density by the configured one"
    )

    @classmethod
    def fitted(cls, config: Setup) -> FittedKey | None:
        """Return the density of the body's material, where inertia feels it."""
        density = config.material.density_kg_m3
        key = "material.density_kg_m3"
        return FittedKey(key, density, 0.0) if config.experiment.dynamic else None

    def adapt[S: Setup](self, config: S) -> S:
        """``config`` with the true density."""
        return config.changed(
            material={"density_kg_m3": self.factor * config.material.density_kg_m3}
        )
