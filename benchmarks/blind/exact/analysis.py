"""One analysis: covariance, candidates and thresholds, prepared once for any residual."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from benchmarks.blind.exact import posterior as hypotheses
from benchmarks.blind.exact import thresholds as calibration
from benchmarks.blind.exact.pairs import Pairs, PairScores
from benchmarks.blind.exact.posterior import Posterior
from benchmarks.blind.exact.thresholds import Thresholds
from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.posterior import HypothesisWeights, LogPriors
from dolfingrip.diagnosis.inference.screen import Score, Screen
from dolfingrip.diagnosis.inference.unknown import SmoothMisfit

FREE = 10.0
"""Factor by which an effect's prior is widened where its strength is left free."""


@dataclass(frozen=True, eq=False)
class Findings:
    """What one residual says under one covariance.

    Attributes:
        whitened: the residual, shape (n,).
        scores: of each candidate alone.
        pairs: of the visible candidates.
        posterior: probabilities of all hypotheses.
        log_density: ln of the residual's probability density, averaged over all hypotheses; it
            compares covariances with one another.
    """

    whitened: Vector
    scores: tuple[Score, ...]
    pairs: PairScores
    posterior: Posterior
    log_density: float


class Analysis:
    """Everything that does not depend on the residual.

    Attributes:
        index: table of the readings.
        covariance: of a residual without a cause.
        screen, unknown, pairs: hypotheses, prepared for the covariance.
    """

    def __init__(
        self,
        index: pd.DataFrame,
        screen: Screen,
        noise_std: Vector,
        weights: HypothesisWeights | None = None,
        thresholds: Thresholds | None = None,
    ) -> None:
        """Prepare.

        Args:
            index: table of the n readings.
            screen: effects that may be the cause, whitened by the covariance of a residual without
                one: of noise, nuisances and mesh.
            noise_std: standard deviation of each reading's noise alone, shape (n,).
            weights: of the kinds of hypotheses.
            thresholds: calibrated by simulation where None.
        """
        self.index = index
        self.covariance = screen.covariance
        self.screen = screen
        self.unknown = SmoothMisfit(index, screen.covariance, noise_std)
        self.pairs = Pairs(screen)
        self.priors = LogPriors.of(weights or HypothesisWeights(), self.screen.visible)
        self._thresholds = thresholds

    @cached_property
    def thresholds(self) -> Thresholds:
        """Log odds above which something is claimed."""
        return self._thresholds or calibration.of_analysis(
            self.screen, self.pairs, self.unknown, self.priors
        )

    def findings(self, residual: Vector) -> Findings:
        """Evidence and probabilities for a residual, measured − simulated, shape (n,)."""
        whitened = self.covariance.whiten(residual)
        scores = self.screen.scores(whitened)
        pairs = self.pairs.scores(whitened)
        one = whitened[:, None]
        found, log_mean = hypotheses.posterior(
            self.priors,
            np.array([score.log_evidence for score in scores]),
            pairs,
            float(self.unknown.log_evidence(one)[0]),
            self.unknown.beside(self.screen, one)[:, 0],
        )
        none = -0.5 * (whitened @ whitened + self.covariance.logdet)
        density = float(none - 0.5 * len(whitened) * np.log(2 * np.pi) + log_mean)
        return Findings(whitened, tuple(scores), pairs, found, density)
