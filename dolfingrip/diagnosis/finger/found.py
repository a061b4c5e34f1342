"""What was found about fingers: fitted numbers, nuisances, and the extended configuration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.additions.next_experiment import Then
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.answer.found import Diagnosis, OfTheRig
from dolfingrip.diagnosis.answer.found import fitted as fitted_readings
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.finger.case import FingerCase
from dolfingrip.diagnosis.finger.next_experiment import then
from dolfingrip.diagnosis.simulation.nuisances import WALL
from dolfingrip.sections.section import Role

MESH_UNKNOWN: Final = (
    "what the mesh gets wrong is taken as nothing, as only a graded mesh of hexahedra tells it: it "
    "may be named as an effect; compare readings with a finer mesh (mesh.refine=2, mesh.size_mm)"
)
"""Said where there is no second mesh to compare with."""


@dataclass(eq=False)
class FingerDiagnosis(Diagnosis):
    """Everything that was found about fingers, and coupons beside them."""

    analysed: FingerCase

    load: ClassVar[str] = "pressure"
    beside: ClassVar[str] = "what else the rig may be off by"

    @property
    def model(self) -> Config:
        return self.analysed.simulation.applied

    def own(self, c: np.ndarray, zeta: np.ndarray) -> dict[str, np.ndarray]:
        found = super().own(c, zeta)
        if self.analysed.wall_std:
            key, wall_mm = self.analysed.wall()
            found[key] = wall_mm * self.analysed.walls(zeta[:, 1])
        return found

    def walls(self, fit: Fit) -> str:
        if not self.analysed.wall_std:
            return ""
        thicker = 100 * (float(self.analysed.walls(fit.zeta[1])) - 1)
        return (
            f"walls {abs(thicker):.2g} % {'thicker' if thicker > 0 else 'thinner'} than configured"
        )

    def nuisances(self, fit: Fit) -> dict[str, float]:
        found = super().nuisances(fit)
        if self.analysed.wall_std:
            found[WALL] = float(fit.zeta[1])
        return found | self.analysed.nuisances(fit)

    def rig(self, fit: Fit) -> list[OfTheRig]:
        """Gain, zero, gap and others that are told; a cause's number is told as one."""
        fitted = self.analysed.nuisances(fit)
        found = []
        for each in self.analysed.errors.shared:
            if not each.std or each.name.startswith("specimen_scale"):
                continue
            size, unit = (1.0, each.unit) if each.unit else (100.0, "%")
            value = size * each.std * fitted[each.name]
            share = self.share(fitted[each.name] * each.change)
            found.append(OfTheRig(each.name, unit, size * each.std, value, share))
        return found

    def as_configured(self) -> np.ndarray:
        return self.analysed.simulation.configured

    def with_best_modulus(self) -> np.ndarray:
        return fitted_readings(self.analysed, self.none)

    def hidden(self) -> str:
        return ", ".join(self.analysed.unseen)

    def cautions(self) -> list[str]:
        told = [f"{name} could not be tried: {why}" for name, why in self.analysed.failed.items()]
        return told if self.analysed.simulation.mesh.size else [MESH_UNKNOWN, *told]

    def then(self, proposal: Proposal, fits: Sequence[Fit]) -> Then:
        return then(self.analysed, proposal, fits)

    def afterwards(self) -> str:
        if self.decision.answer == "unknown":
            return "another channel, unloading, or a coupon: they would tell what kind it is of"
        if self.decision.answer == "none":
            return "nothing: the readings agree with the model within their noise"
        if len(self.decision.first) > 1:
            names = ", ".join(self.decision.first)
            return f"measure one of these by itself: {names}; the readings do not tell them apart"
        return "nothing is needed: no other cause is nearly as probable as what is named"

    @property
    def extended(self) -> Config:
        """The finger as it was drawn for the tests, at the answer's numbers; no set-up."""
        told = self.analysed.measurement.tests[0].setup.sections
        classes = Config.classes()
        drawn = {name: told[name] for name in told if classes[name].role is Role.BODY}
        config = self.config.changed(**drawn) if drawn else self.config
        return changed(config, self.overrides(self.decision.best))

    def overrides(self, fit: Fit) -> Change:
        """Return the change that makes the configuration the fitted one."""
        return {**self.analysed.overrides(fit), **self.analysed.own_overrides(fit)}
