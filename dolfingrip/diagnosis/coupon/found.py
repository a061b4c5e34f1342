"""What was found about coupons: exact simulations at fitted numbers, and their intervals."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.decision import Decision
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import NONE, Posterior
from dolfingrip.diagnosis.core.sensitivity import Sensitivity
from dolfingrip.diagnosis.coupon.case import CouponCase, causes_at
from dolfingrip.diagnosis.coupon.gain import HeldOut
from dolfingrip.diagnosis.outcome import Downstream, NextExperiment, Parameter
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.parameter import find, moduli, scaled


@dataclass(eq=False)
class CouponDiagnosis:
    """Everything that was found about coupons.

    Attributes:
        config: the model that was diagnosed.
        coupons: readings, emulators and covariance.
        posterior: probabilities of all hypotheses.
        decision: the answer.
        sensitivity: answers under other priors.
        left_by_emulator: largest difference of the emulator from the exact simulation at the
            answer's numbers, by the noise.
        held_out: errors on readings that were left out; None where nothing was.
        next: additions, the best first.
        suspicions: doubts about the data, a sentence each.
        warnings: what else to beware of.
        not_reached: tests with readings that the model does not reach, and why.
        downstream: what the extended model changes about a campaign's designs.
        simulated_s: time of all simulations.
        load: what readings lie along.
        beside: what is fitted beside the causes, in words.
    """

    config: Config
    coupons: CouponCase
    posterior: Posterior
    decision: Decision
    sensitivity: Sensitivity
    left_by_emulator: float
    held_out: HeldOut | None = None
    next: list[NextExperiment] = field(default_factory=list)
    suspicions: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    not_reached: list[str] = field(default_factory=list)
    simulated_s: float = 0.0
    downstream: Downstream | None = None

    load: ClassVar[str] = "strain"
    beside: ClassVar[str] = "each coupon's own stiffness and slack"

    @property
    def none(self) -> Fit:
        """The model as it is, its modulus fitted."""
        return self.posterior.best(NONE, level=0.0)

    def numbers(self, fit: Fit) -> list[Parameter]:
        """Fitted numbers by key of the configuration; moduli at the fitted modulus."""
        case = self.coupons.case
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
            cause = self.coupons.causes.get(name)
            if cause is None:
                shared = next(each for each in self.coupons.errors.shared if each.name == name)
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
        """The model's own numbers that are fitted, as configured, by key."""
        keys = [key for key in moduli(self.config) if "bulk" not in key]
        return {each.key: each.value(self.config) for each in find(self.config, keys)}

    def fitted(self, fit: Fit) -> str:
        """What of the model's own was fitted, in a sentence."""
        c = float(self.coupons.case.factor(fit.zeta[0])[0])
        return f"A modulus {times(c)} the configured one is fitted."

    def nuisances(self, fit: Fit) -> dict[str, float]:
        """Fitted nuisances by their standard deviations."""
        case = self.coupons.case
        return {"modulus": float(np.log(case.factor(fit.zeta[0])[0]) / case.modulus_std)}

    def rig(self, fit: Fit) -> list[OfTheRig]:
        """The rig's numbers at a fit."""
        weighed, _ = left(self.coupons, fit)
        found, place = [], 1
        far: dict[str, float] = {}
        for name in fit.subset:
            far[name] = POLICY.far * float(fit.zeta[place])
            place += len(self.coupons.case.boxes[name])
        for each in self.coupons.errors.shared:
            if not each.std:  # known exactly
                continue
            sigma = float(each.change @ weighed) + far.get(each.name, 0.0)
            share = self.share(sigma * each.change)
            found.append(OfTheRig(each.name, each.unit, each.std, sigma * each.std, share))
        return found

    def share(self, change: np.ndarray) -> float:
        """A change of the readings, (n,), by what the model as configured misses, both rms."""
        off = self.coupons.case.value - self.as_configured()
        come = np.isfinite(off)
        missed = float(np.linalg.norm(off[come]))
        return float(np.linalg.norm(change[come])) / missed if missed else 0.0

    def as_configured(self) -> np.ndarray:
        """(n,) readings of the model as configured; NaN where it does not come so far."""
        return self.coupons.case.base

    def with_best_modulus(self) -> np.ndarray:
        """(n,) readings of the model without causes, what is its own fitted."""
        return with_best_modulus(self.coupons)

    def afterwards(self) -> str | None:
        """What to do next where no cause is tied with another, if it is no coupons' matter."""
        return None

    @property
    def extended(self) -> Config:
        """The configuration at the answer's numbers."""
        return self.config.overridden(self.overrides(self.decision.best))

    def overrides(self, fit: Fit) -> tuple[str, ...]:
        """What makes the configuration the fitted one, as with ``--set``."""
        factor = float(self.coupons.case.factor(fit.zeta[0])[0])
        return (*scaled(self.config, factor), *causes_at(self.coupons, fit, factor))


def exact(coupons: CouponCase, fit: Fit) -> np.ndarray:
    """(n,) readings by an exact simulation at a fit's numbers, linear nuisances left out."""
    return coupons.exact(fit)


def left(coupons: CouponCase, fit: Fit) -> tuple[np.ndarray, np.ndarray]:
    """What an exact simulation at a fit leaves of the readings, by C⁻¹ and itself, (n,) each."""
    case = coupons.case
    rest = case.value - exact(coupons, fit)
    total = case.covariance + fit.level**2 * case.kernel
    return np.asarray(np.linalg.solve(total, rest)), rest


def fitted(coupons: CouponCase, fit: Fit) -> np.ndarray:
    """(n,) exact readings at a fit, with the slack and the stiffness that coupons have there."""
    weighed, rest = left(coupons, fit)
    return np.asarray(coupons.case.value - rest + coupons.errors.fitted @ weighed)


def with_best_modulus(coupons: CouponCase) -> np.ndarray:
    """(n,) readings as configured but for the modulus, the one that leaves least."""
    case = coupons.case
    scaled = case.base * case.scaled
    square = float(scaled @ scaled)
    factor = float(scaled @ case.value) / square if square > 0 else 1.0
    return np.where(case.scaled, factor, 1.0) * case.base


@dataclass(frozen=True, slots=True)
class OfTheRig:
    """A number of the rig, as the readings tell it.

    Attributes:
        name, unit: of it.
        told: standard deviation that it was told with.
        value: difference from what was told.
        share: what it changes by what the model misses as configured, root mean square.
    """

    name: str
    unit: str
    told: float
    value: float
    share: float

    @property
    def telling(self) -> bool:
        """Whether it is far from what was told, or explains much of what the model misses."""
        return abs(self.value) > POLICY.far_sigma * self.told or self.share >= POLICY.telling


def by_hessian(fit: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Draws from the normal distribution about the most probable numbers."""
    rng = np.random.default_rng(0)
    lower = np.linalg.cholesky(np.linalg.inv(fit.hessian))
    draws = fit.zeta + rng.standard_normal((POLICY.draws, len(fit.zeta))) @ lower.T
    return draws, np.full(POLICY.draws, 1 / POLICY.draws)


def estimated(key: str, value: float, draws: np.ndarray, weights: np.ndarray) -> Parameter:
    order = np.argsort(draws)
    total = np.cumsum(weights[order])
    tail = (1 - POLICY.interval) / 2
    low, high = (float(draws[order][np.searchsorted(total, p)]) for p in (tail, 1 - tail - 1e-9))
    value = float(value)
    return Parameter(key=key, value=value, low=min(low, value), high=max(high, value))


def times(factor: float) -> str:
    """A factor in words."""
    if 0.5 < factor < 2:
        return f"{abs(100 * (factor - 1)):.2g} % {'above' if factor > 1 else 'below'}"
    return f"{factor:.3g} times"
