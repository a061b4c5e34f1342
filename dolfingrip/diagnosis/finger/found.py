"""What was found about fingers: fitted numbers, nuisances, and the extended configuration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.coupon.found import CouponDiagnosis, Estimated, by_hessian, estimated
from dolfingrip.diagnosis.finger.case import FingerCase, far
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import WALL
from dolfingrip.parameter import find, moduli
from dolfingrip.sections.geometry.index import TABLES

DRAWN = (*TABLES, "morph", "material", "film")
"""Sections of a set-up that are properties of the finger."""


@dataclass(eq=False)
class FingerDiagnosis(CouponDiagnosis):
    """Everything that was found about fingers, and coupons beside them."""

    coupons: FingerCase  # type: ignore[assignment]

    load = "pressure or travel"

    def configured(self) -> dict[str, float]:
        applied = self.coupons.simulation.applied
        keys = [key for key in moduli(applied) if "bulk" not in key]
        found = {each.key: each.value(applied) for each in find(applied, keys)}
        if self.coupons.wall_std:
            key, wall_mm = self.coupons.wall()
            found[key] = wall_mm
        return found

    def fitted(self, fit: Fit) -> str:
        told = f"Fitted to make it agree: a modulus {_by(self.coupons.factor(fit), 'higher lower')}"
        if self.coupons.wall_std:
            walls = float(self.coupons.walls(fit.zeta[1]))
            told += f" and walls {_by(walls, 'thicker thinner')}"
        return f"{told}."

    def nuisances(self, fit: Fit) -> dict[str, float]:
        case = self.coupons.case
        found = {"modulus": float(np.log(case.factor(fit.zeta[0])[0]) / case.modulus_std)}
        if self.coupons.wall_std:
            found[WALL] = float(far(fit.zeta[1]))
        return found | self.coupons.nuisances(fit)

    def far_out(self, fit: Fit) -> list[str]:
        fitted = self.coupons.nuisances(fit)
        told = []
        for each in self.coupons.errors.shared:
            zeta = fitted[each.name]
            if abs(zeta) > POLICY.far_out:
                name = each.name.replace("_kPa", "").replace("_mm", "").replace("_", " ")
                size = zeta * each.std
                value = f"{size:+.2g} {each.unit}" if each.unit else f"{100 * size:+.2g} %"
                told.append(
                    f"{name} {value}, {abs(zeta):.1f} standard deviations from what is told"
                )
        return told

    def afterwards(self) -> str:
        if self.decision.answer == "unknown":
            return "another channel, unloading, or a coupon: they would tell what kind it is of"
        if self.decision.answer == "none":
            return "nothing: the readings agree with the model within their noise"
        return "nothing is needed: no other cause is tied with what is named"

    def numbers(self, fit: Fit) -> list[Estimated]:
        """Fitted numbers by key of the configuration; moduli at the fitted modulus."""
        finger, case = self.coupons, self.coupons.case
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
                times = c if number.key.endswith("_MPa") else 1.0
                add(number.key, number.at(draws[:, place]) * times)
                place += 1
        return found

    @property
    def extended(self) -> Config:
        """The finger as it was drawn for the tests, at the answer's numbers; no set-up."""
        told = self.coupons.simulation.measurement.tests[0].setup.sections
        drawn = {name: told[name] for name in DRAWN if name in told}
        config = self.config.changed(**drawn) if drawn else self.config
        return config.overridden(self.overrides(self.decision.best))

    def overrides(self, fit: Fit) -> tuple[str, ...]:
        """What makes the configuration the fitted one, as with ``--set``."""
        return self.coupons.overrides(fit)


def _by(factor: float, ways: str) -> str:
    """What a factor of a configured number is, in words."""
    if not 0.5 < factor < 1.5:
        return f"{factor:.2g} times as configured"
    more, less = ways.split()
    return f"{abs(100 * (factor - 1)):.2g} % {more if factor > 1 else less} than configured"
