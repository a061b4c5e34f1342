"""What was found about coupons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dolfingrip.diagnosis.answer.found import (
    Diagnosis,
    OfTheRig,
    by_hessian,
    estimated,
    left,
    times,
)
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.coupon.case import CouponCase, causes_at
from dolfingrip.diagnosis.outcome import Parameter
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import find, moduli, scaled


@dataclass(eq=False)
class CouponDiagnosis(Diagnosis):
    """Everything that was found about coupons."""

    analysed: CouponCase

    load: ClassVar[str] = "strain"
    beside: ClassVar[str] = "each coupon's own stiffness and slack"

    def numbers(self, fit: Fit) -> list[Parameter]:
        case = self.analysed.case
        draws, weights = fit.draws or by_hessian(fit)
        c, _ = case.factor(draws[:, 0])
        at_c = float(case.factor(fit.zeta[0])[0])
        found = [
            estimated(
                each.key, each.value(self.config) * at_c, each.value(self.config) * c, weights
            )
            for each in find(self.config, [k for k in moduli(self.config) if "bulk" not in k])
        ]
        place = 1
        for name in fit.subset:
            cause = self.analysed.causes.get(name)
            if cause is None:
                shared = next(each for each in self.analysed.errors.shared if each.name == name)
                wide = POLICY.far * shared.std
                found.append(
                    estimated(name, wide * fit.zeta[place], wide * draws[:, place], weights)
                )
                place += 1
                continue
            for number in cause.numbers:
                times = number.key.endswith("_MPa")
                value = float(number.at(fit.zeta[place])) * (at_c if times else 1.0)
                told = number.at(draws[:, place]) * (c if times else 1.0)
                found.append(estimated(number.key, value, told, weights))
                place += 1
        return found

    def configured(self) -> dict[str, float]:
        keys = [key for key in moduli(self.config) if "bulk" not in key]
        return {each.key: each.value(self.config) for each in find(self.config, keys)}

    def fitted(self, fit: Fit) -> str:
        c = float(self.analysed.case.factor(fit.zeta[0])[0])
        return f"A modulus {times(c)} the configured one is fitted."

    def nuisances(self, fit: Fit) -> dict[str, float]:
        case = self.analysed.case
        return {"modulus": float(np.log(case.factor(fit.zeta[0])[0]) / case.modulus_std)}

    def rig(self, fit: Fit) -> list[OfTheRig]:
        weighed, _ = left(self.analysed, fit)
        found, place = [], 1
        far: dict[str, float] = {}
        for name in fit.subset:
            far[name] = POLICY.far * float(fit.zeta[place])
            place += len(self.analysed.case.boxes[name])
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
        case = self.analysed.case
        proportional = case.base * case.scaled
        square = float(proportional @ proportional)
        factor = float(proportional @ case.value) / square if square > 0 else 1.0
        return np.where(case.scaled, factor, 1.0) * case.base

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

    def afterwards(self) -> str:
        decision, rig = self.decision, self.analysed.case.rig
        if decision.answer == "unknown":
            return "a coupon, up and down at two rates: it would tell memory from elasticity"
        if decision.answer == "none":
            return "measure the finger: the coupons agree with the model"
        if decision.first == self.analysed.case.scale_names:
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

    def overrides(self, fit: Fit) -> tuple[str, ...]:
        factor = float(self.analysed.case.factor(fit.zeta[0])[0])
        return (*scaled(self.config, factor), *causes_at(self.analysed, fit, factor))
