"""What was found about fingers: fitted numbers, nuisances, and the extended configuration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.found import (
    Diagnosis,
    OfTheRig,
    by_hessian,
    estimated,
    times,
)
from dolfingrip.diagnosis.answer.found import fitted as fitted_readings
from dolfingrip.diagnosis.core import tails
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.finger.case import DRAWN, FingerCase
from dolfingrip.diagnosis.outcome import Parameter
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import WALL
from dolfingrip.parameter import find, moduli


@dataclass(eq=False)
class FingerDiagnosis(Diagnosis):
    """Everything that was found about fingers, and coupons beside them."""

    analysed: FingerCase

    load: ClassVar[str] = "pressure"
    beside: ClassVar[str] = "what else the rig may be off by"

    def configured(self) -> dict[str, float]:
        applied = self.analysed.simulation.applied
        keys = [key for key in moduli(applied) if "bulk" not in key]
        found = {each.key: each.value(applied) for each in find(applied, keys)}
        if self.analysed.wall_std:
            key, wall_mm = self.analysed.wall()
            found[key] = wall_mm
        return found

    def fitted(self, fit: Fit) -> str:
        sigma = abs(self.nuisances(fit)["modulus"])
        told = f"A modulus {times(self.analysed.factor(fit))} the configured one"
        if sigma > POLICY.far_sigma:
            std = 100 * self.analysed.case.modulus_std
            told += f" (±{std:.2g} % was told: {sigma:.1f} standard deviations)"
        if not self.analysed.wall_std:
            return f"{told} is fitted."
        walls = 100 * (float(self.analysed.walls(fit.zeta[1])) - 1)
        way = "thicker" if walls > 0 else "thinner"
        return f"{told} and walls {abs(walls):.2g} % {way} than configured are fitted."

    def nuisances(self, fit: Fit) -> dict[str, float]:
        case = self.analysed.case
        found = {"modulus": float(np.log(case.factor(fit.zeta[0])[0]) / case.modulus_std)}
        if self.analysed.wall_std:
            found[WALL] = float(tails.off(fit.zeta[1]))
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

    def afterwards(self) -> str:
        if self.decision.answer == "unknown":
            return "another channel, unloading, or a coupon: they would tell what kind it is of"
        if self.decision.answer == "none":
            return "nothing: the readings agree with the model within their noise"
        return "nothing is needed: no other cause is nearly as probable as what is named"

    def numbers(self, fit: Fit) -> list[Parameter]:
        """Fitted numbers by key of the configuration; moduli at the fitted modulus."""
        finger, case = self.analysed, self.analysed.case
        draws, weights = fit.draws or by_hessian(fit)
        draws = np.vstack([fit.zeta, draws])
        weights = np.r_[0.0, weights]
        c = case.factor(draws[:, 0])[0]
        applied = finger.simulation.applied
        found = []

        def add(key: str, values: np.ndarray) -> None:
            found.append(estimated(key, float(values[0]), values[1:], weights[1:]))

        for each in find(applied, [key for key in moduli(applied) if "bulk" not in key]):
            add(each.key, each.value(applied) * c)
        if finger.wall_std:
            key, wall_mm = finger.wall()
            add(key, wall_mm * finger.walls(draws[:, 1]))
        place = case.own
        for name in fit.subset:
            for number in finger.causes[name].numbers:
                scale = c if number.key.endswith("_MPa") else 1.0
                add(number.key, number.at(draws[:, place]) * scale)
                place += 1
        return found

    @property
    def extended(self) -> Config:
        """The finger as it was drawn for the tests, at the answer's numbers; no set-up."""
        told = self.analysed.measurement.tests[0].setup.sections
        drawn = {name: told[name] for name in DRAWN if name in told}
        config = self.config.changed(**drawn) if drawn else self.config
        return config.overridden(self.overrides(self.decision.best))

    def overrides(self, fit: Fit) -> tuple[str, ...]:
        """What makes the configuration the fitted one, as with ``--set``."""
        return (*self.analysed.overrides(fit), *self.analysed.own_overrides(fit))
