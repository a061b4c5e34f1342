"""A diagnosis: the answer, fitted numbers and their intervals."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.additions.worth import PredictedAddition
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.answer.gain import HeldOut
from dolfingrip.diagnosis.core.decision import Decision, Sensitivity
from dolfingrip.diagnosis.core.evidence import MapFit
from dolfingrip.diagnosis.core.search import NONE, ModelPosterior
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import modulus_keys
from dolfingrip.files.diagnosis import Downstream, FittedNumber, NextExperiment
from dolfingrip.parameter import find


@dataclass(eq=False)
class Diagnosis(ABC):
    """Everything that was found.

    Attributes:
        config: the model that was diagnosed.
        analysis: readings, emulators and covariance.
        posterior: probabilities of all hypotheses.
        decision: the answer.
        sensitivity: answers under other priors.
        left_by_emulator: largest difference of the emulator from the exact simulation at the
            answer's numbers, by the noise.
        held_out: errors on readings that were left out; None where nothing was.
        next: additions, the best first.
        suspicions: doubts about the data, a sentence each.
        warnings: what else to beware of.
        downstream: what the extended model changes about a campaign's designs.
        simulated_s: time of all simulations.
        quick: whether it stopped after the screen.
        load: what readings lie along.
        beside: what is fitted beside the causes, in words.
    """

    config: Config
    analysis: Analysis[Any]
    posterior: ModelPosterior
    decision: Decision
    sensitivity: Sensitivity
    left_by_emulator: float
    held_out: HeldOut | None = None
    next: list[NextExperiment] = field(default_factory=list)
    suspicions: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    simulated_s: float = 0.0
    quick: bool = False
    downstream: Downstream | None = None

    load: ClassVar[str]
    beside: ClassVar[str]

    @property
    def none(self) -> MapFit:
        """The model as it is, its modulus fitted."""
        return self.posterior.best(NONE, level=0.0)

    @property
    @abstractmethod
    def model(self) -> Config:
        """Whose moduli are fitted."""

    def nuisance_values(self, c: np.ndarray, zeta: np.ndarray) -> dict[str, np.ndarray]:
        """The model's own numbers that are fitted, by key, shape (places,).

        Args:
            c: factor of all moduli, shape (places,).
            zeta: shape (places, d).
        """
        return {
            each.key: each.value(self.model) * c
            for each in find(self.model, modulus_keys(self.model))
        }

    def configured(self) -> dict[str, float]:
        """Return the nuisances as configured."""
        middle = np.zeros((1, self.analysis.problem.nuisance_count))
        return {
            key: float(values[0])
            for key, values in self.nuisance_values(np.ones(1), middle).items()
        }

    def numbers(self, fit: MapFit) -> list[FittedNumber]:
        """Fitted numbers by key of the configuration; moduli at the fitted modulus."""
        told, problem = self.analysis, self.analysis.problem
        draws, weights = fit.draws or _by_hessian(fit)
        every = np.vstack([fit.zeta, draws])
        c = problem.factor(every[:, 0])
        values = list(self.nuisance_values(c, every).items())
        for name, places in problem.places(fit.subset).items():
            cause = told.causes.get(name) or told.implausible[name]
            for number, place in zip(cause.numbers, places, strict=True):
                scale = c if name in told.causes and number.modulus else 1.0
                values.append((number.key, number.at(every[:, place]) * scale))
        return [_estimated(key, float(each[0]), each[1:], weights) for key, each in values]

    def fitted(self, fit: MapFit) -> str:
        """Tell in a sentence which numbers of the model were fitted."""
        sigma = abs(float(fit.zeta[0]))
        told = f"A modulus {_times(self.analysis.factor(fit))} the configured one"
        if sigma > POLICY.implausible_sigma:
            std = 100 * self.analysis.problem.factor.std
            told += f" (prior ±{std:.2g} %: {sigma:.1f} standard deviations)"
        walls = self.walls(fit)
        return f"{told} and {walls} are fitted." if walls else f"{told} is fitted."

    def walls(self, fit: MapFit) -> str:
        """How thick the walls are that were fitted, in words; empty where they were not."""
        return ""

    def nuisances(self, fit: MapFit) -> dict[str, float]:
        """Fitted nuisances by their standard deviations."""
        return {"modulus": float(fit.zeta[0])}

    @abstractmethod
    def setup_deviations(self, fit: MapFit) -> dict[str, float]:
        """Deviations of the rig's numbers from their priors' means, in standard deviations."""

    def setup_estimates(self, fit: MapFit) -> list[SetupEstimate]:
        """Numbers of the rig at a fit, but those known exactly."""
        deviations, found = self.setup_deviations(fit), []
        for each in self.analysis.errors.shared:
            if not each.std or each.name.startswith("specimen_scale"):
                continue
            # a number of the configuration is absolute, all others without a unit are relative
            relative = not each.unit and "." not in each.name
            size, unit = (100.0, "%") if relative else (1.0, each.unit)
            sigma, std = deviations[each.name], size * each.std
            share = self.share(sigma * each.change)
            found.append(SetupEstimate(each.name, unit, std, sigma * std, share))
        return found

    @abstractmethod
    def as_configured(self) -> np.ndarray:
        """(n,) readings of the model as configured; NaN where it does not come so far."""

    @abstractmethod
    def with_best_modulus(self) -> np.ndarray:
        """(n,) readings of the model without causes, what is its own fitted."""

    @abstractmethod
    def hidden(self) -> str:
        """Causes that the readings cannot feel, in words; empty where they feel all."""

    @abstractmethod
    def cautions(self) -> list[str]:
        """List what to beware of, a sentence each."""

    @abstractmethod
    def predict_addition(self, proposal: Proposal, fits: Sequence[MapFit]) -> PredictedAddition:
        """Tied hypotheses at the readings of an addition."""

    @abstractmethod
    def advice(self) -> str:
        """Advise what to do next where no cause is tied with another."""

    @abstractmethod
    def overrides(self, fit: MapFit) -> Change:
        """Return the change that makes the configuration the fitted one."""

    def share(self, change: np.ndarray) -> float:
        """A change of the readings, (n,), by what the model as configured misses, both rms."""
        off = self.analysis.problem.value - self.as_configured()
        come = np.isfinite(off)
        missed = float(np.linalg.norm(off[come]))
        return float(np.linalg.norm(change[come])) / missed if missed else 0.0

    @property
    def extended(self) -> Config:
        """The configuration at the answer's numbers."""
        return changed(self.config, self.overrides(self.decision.best))


def left(analysis: Analysis[Any], fit: MapFit) -> tuple[np.ndarray, np.ndarray]:
    """Return the residual of an exact simulation at a fit, by C⁻¹ and itself, (n,) each."""
    problem = analysis.problem
    rest = problem.value - analysis.exact(fit)
    total = problem.covariance + fit.level**2 * problem.kernel
    return np.asarray(np.linalg.solve(total, rest)), rest


def fitted(analysis: Analysis[Any], fit: MapFit) -> np.ndarray:
    """(n,) exact readings at a fit, with the slack and the stiffness that coupons have there."""
    weighed, rest = left(analysis, fit)
    return np.asarray(analysis.problem.value - rest + analysis.errors.fitted @ weighed)


@dataclass(frozen=True, slots=True)
class SetupEstimate:
    """A number of the rig, as the readings tell it.

    Attributes:
        name, unit: of it.
        prior_std: its prior standard deviation.
        value: difference from what was told.
        share: what it changes by what the model misses as configured, root mean square.
    """

    name: str
    unit: str
    prior_std: float
    value: float
    share: float

    @property
    def telling(self) -> bool:
        """True if it is implausible by its prior, or explains much of what the model misses."""
        return (
            abs(self.value) > POLICY.implausible_sigma * self.prior_std
            or self.share >= POLICY.telling
        )


def _by_hessian(fit: MapFit) -> tuple[np.ndarray, np.ndarray]:
    """Draws from the normal distribution about the most probable numbers."""
    rng = np.random.default_rng(0)
    lower = np.linalg.cholesky(np.linalg.inv(fit.hessian))
    draws = fit.zeta + rng.standard_normal((POLICY.draws, len(fit.zeta))) @ lower.T
    return draws, np.full(POLICY.draws, 1 / POLICY.draws)


def _estimated(key: str, value: float, draws: np.ndarray, weights: np.ndarray) -> FittedNumber:
    """A number and its interval, by draws of it with weights, shapes (draws,)."""
    order = np.argsort(draws)
    total = np.cumsum(weights[order])
    tail = (1 - POLICY.interval) / 2
    low, high = (float(draws[order][np.searchsorted(total, p)]) for p in (tail, 1 - tail - 1e-9))
    return FittedNumber(key=key, value=value, low=min(low, value), high=max(high, value))


def _times(factor: float) -> str:
    """A factor in words."""
    if 0.5 < factor < 2:
        return f"{abs(100 * (factor - 1)):.2g} % {'above' if factor > 1 else 'below'}"
    return f"{factor:.3g} times"
