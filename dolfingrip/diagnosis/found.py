"""Everything that a diagnosis found: the record that tables, plots and texts are made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from dolfingrip.diagnosis import extend
from dolfingrip.diagnosis.additions import worth
from dolfingrip.diagnosis.conclude import NONE, Conclusion
from dolfingrip.diagnosis.downstream import Downstream
from dolfingrip.diagnosis.gain.gain import GainRow
from dolfingrip.diagnosis.gain.odds import Odds, claimed
from dolfingrip.diagnosis.gain.rivals import NuisanceFit
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.laplace import Estimate
from dolfingrip.diagnosis.inference.posterior import Posterior
from dolfingrip.diagnosis.inference.verdict import Verdict
from dolfingrip.diagnosis.model import area_spread, coupons_alone
from dolfingrip.diagnosis.noise_check import NoiseDoubts
from dolfingrip.diagnosis.noise_model import NoiseModel
from dolfingrip.diagnosis.problem import Problem


@dataclass
class Diagnosis:
    """Everything that was found, for tables, plots and texts.

    Attributes:
        problem: arrays of the readings.
        noise: what was taken.
        fits: of hypotheses.
        conclusion: under the most probable model of the noise.
        verdict: averaged over these models.
        under: the verdict under each alone.
        models: probability of each.
        posterior: probabilities of all hypotheses, averaged over these models.
        doubts: what speaks against the noise as believed.
        gain: errors on what was left out.
        odds: of what was left out, for the cause.
        next: additions, the best first.
        downstream: what the extended model changes about a campaign's best designs.
        suspicions: slips of units, signs and columns, a question each.
        not_reached: tests with readings that the base simulation does not reach, and why.
        warnings: what else to beware of, a sentence each.
        quick: whether it stopped after the screen.
        simulated_s: time of all simulations on a worker each, those from the store included.
    """

    problem: Problem
    noise: NoiseModel
    fits: Mapping[frozenset[str], Hypothesis]
    conclusion: Conclusion
    verdict: Verdict
    under: Mapping[str, Verdict]
    models: Mapping[str, float]
    posterior: Posterior
    doubts: NoiseDoubts
    gain: list[GainRow] = field(default_factory=list)
    odds: list[Odds] = field(default_factory=list)
    next: list[worth.AdditionWorth] = field(default_factory=list)
    downstream: Downstream | None = None
    suspicions: list[str] = field(default_factory=list)
    not_reached: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    quick: bool = False
    simulated_s: float = 0.0

    @property
    def none(self) -> Hypothesis:
        """The base model, its modulus fitted."""
        return self.fits[NONE]

    @property
    def best(self) -> Hypothesis:
        """The fit that the verdict is about; the base model's where it names no cause."""
        if self.verdict.answer != "cause":
            return self.none
        leaders = [found.names[0] for found in self.verdict.named]
        for key in (frozenset(leaders), frozenset(leaders[:1])):
            if key in self.fits:
                return self.fits[key]
        return self.none

    def numbers(self, fit: Hypothesis) -> list[tuple[str, Estimate]]:
        """Fitted numbers by key of the configuration, with 90 % intervals."""
        measurement = self.problem.measurement
        area = area_spread(measurement) if coupons_alone(measurement) else 0.0
        config = self.problem.base.config
        return extend.parameters(config, fit, fit.estimates(self.problem), area)

    @cached_property
    def nuisances_fitted(self) -> Vector:
        """The base model with its nuisances fitted as well as they can be, shape (n,)."""
        everything = np.ones(len(self.problem.value), dtype=bool)
        return NuisanceFit(self.problem, self.none).refitted(everything).predicted

    @property
    def takes_part(self) -> float:
        """Probability that one of the leading class takes part, beside whatever else."""
        names = [score.name for score in self.conclusion.scores]
        own = [names.index(name) for each in self.verdict.named[:1] for name in each.names]
        found = self.posterior
        return found.with_either(own) + float(found.beside[own].sum()) if own else 0.0

    @property
    def gain_claimed(self) -> bool | None:
        """Whether the cause beats both rivals; None where nothing was compared."""
        return claimed(self.odds) if self.odds else None
