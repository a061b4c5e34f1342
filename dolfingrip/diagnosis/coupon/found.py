"""What was found about coupons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.additions.next_experiment import Then
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.additions.worth import Tied
from dolfingrip.diagnosis.answer.found import Diagnosis, OfTheRig, left
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.coupon.case import CouponCase
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import scaled


@dataclass(eq=False)
class CouponDiagnosis(Diagnosis):
    """Everything that was found about coupons."""

    analysed: CouponCase

    load: ClassVar[str] = "strain"
    beside: ClassVar[str] = "each coupon's own stiffness and slack"

    @property
    def model(self) -> Config:
        return self.config

    def rig(self, fit: Fit) -> list[OfTheRig]:
        weighed, _ = left(self.analysed, fit)
        found = []
        places = self.analysed.case.places(fit.subset)
        far = {name: POLICY.far * float(fit.zeta[own[0]]) for name, own in places.items()}
        for each in self.analysed.errors.shared:
            if not each.std:  # known exactly
                continue
            sigma = float(each.change @ weighed) + far.get(each.name, 0.0)
            share = self.share(sigma * each.change)
            found.append(OfTheRig(each.name, each.unit, each.std, sigma * each.std, share))
        return found

    def as_configured(self) -> np.ndarray:
        return self.analysed.case.base

    def with_best_modulus(self) -> np.ndarray:
        """(n,) readings as configured but for the modulus, the one that leaves least."""
        case, scaled = self.analysed.case, self.analysed.scaled
        proportional = case.base * scaled
        square = float(proportional @ proportional)
        factor = float(proportional @ case.value) / square if square > 0 else 1.0
        return np.where(scaled, factor, 1.0) * case.base

    def hidden(self) -> str:
        unseen = self.analysed.unseen
        material = [n for n in unseen if effect(n).kind in ("elastic", "dissipative")]
        rest = [n for n in unseen if n not in material]
        told = []
        if material:
            told.append(f"{', '.join(material)} (other readings of coupons may tell)")
        if rest:
            told.append(f"what only a finger or another instrument feels: {', '.join(rest)}")
        return "; ".join(told)

    def cautions(self) -> list[str]:
        scatter = self.analysed.errors.scatter
        if not (scatter.estimated and scatter.scale > POLICY.scatters * scatter.told_scale):
            return []
        return [
            f"the specimens' stiffness scatters by {100 * scatter.scale:.2g} %, where "
            f"{100 * scatter.told_scale:.2g} % is believed (nuisance.specimen_scale)"
        ]

    def then(self, proposal: Proposal, fits: Sequence[Fit]) -> Then:
        other = CouponSimulation(proposal.measurement, self.config)
        # the rig's own errors are others then, and a new coupon is another specimen
        after = [
            Tied(e.zeta, *self.analysed.simulated(e.subset, e.zeta, other, rig=False)) for e in fits
        ]
        scatter = self.analysed.errors.scatter
        stiff = max(scatter.scale, scatter.told_scale) * after[0].readings
        return after, np.outer(stiff, stiff), 0.0, False

    def afterwards(self) -> str:
        decision, rig = self.decision, self.analysed.case.rig
        if decision.answer == "unknown":
            return "a coupon, up and down at two rates: it would tell memory from elasticity"
        if decision.answer == "none":
            return "measure the finger: the coupons agree with the model"
        if decision.own:
            return "measure the coupons' cross-section: it is told from the modulus by nothing else"
        named = [n for n in (*decision.first, *decision.second) if n not in rig]
        if self._once() and any(effect(name).kind == "dissipative" for name in named):
            return (
                "a coupon, loading and unloading, with a wait of 60 s between: the curve's shape "
                "alone tells memory here; a loop and a force that fades would prove it"
            )
        return "measure the finger: no other cause is nearly as probable as the first"

    def _once(self) -> bool:
        """Whether each coupon was pulled once, and no more."""
        listed = self.analysed.measurement.listed()
        return len(listed.groupby(["cycle", "branch"])) == 1

    def overrides(self, fit: Fit) -> Change:
        factor = self.analysed.factor(fit)
        return {**scaled(self.config, factor), **self.analysed.at(fit, factor)}
