"""What is attainable in a case: exact evidence with the generator's own columns and covariance.

The same hidden causes and the same draws of nuisances and noise, where nuisances are exactly linear
and every change is known: nobody can do better but by luck. Strengths in σ are what a cause changes
after nuisances, ‖L⁻¹Δ‖ with C = Σ + N Nᵀ = L Lᵀ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from benchmarks.blind import noise
from benchmarks.blind.cases import Case, Readings
from benchmarks.blind.curved import CurvedScreen, CurvedShape
from benchmarks.blind.exact.analysis import Analysis
from benchmarks.blind.exact.folds import folds
from benchmarks.blind.exact.thresholds import Thresholds, of_analysis
from benchmarks.blind.exact.verdict import Verdict, decide
from benchmarks.blind.generator import Cause
from benchmarks.blind.noise import Instruments
from benchmarks.blind.opinions import Interval
from benchmarks.blind.response import NUISANCES, Catalogue, Hidden, Truth
from dolfingrip.diagnosis.inference.candidate import Candidate, Shape
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.noise import noise_matrix
from dolfingrip.diagnosis.inference.posterior import HypothesisWeights

STEP: Final = 0.1
"""Standard deviations over which a nuisance is taken as linear."""
WEIGHTS: Final = HypothesisWeights(none=0.15, single=0.6, pair=0.1, unknown=0.15)
"""How often the plan hides what."""
UNFELT: Final = 1e-9
"""Change of a reading below which there is none, in its unit."""


@dataclass(frozen=True, slots=True)
class Attained:
    """The bound's verdict on a case, and how strong its causes are.

    Attributes:
        verdict: by exact evidence.
        intervals: of the strength of the hidden cause where there is one.
        cut: by how much the true model cuts the error on readings that are left out.
        strengths_sigma: of each hidden cause after nuisances.
        unexplained_sigma: of what the best single cause of the catalogue leaves of all causes.
    """

    verdict: Verdict
    intervals: tuple[Interval, ...]
    cut: float
    strengths_sigma: tuple[float, ...]
    unexplained_sigma: float


class Bound:
    """Exact evidence for the cases of one protocol.

    Args:
        catalogue: the generator's.
        instruments: how they really scatter.
    """

    def __init__(self, catalogue: Catalogue, instruments: Instruments | None = None) -> None:
        """Compute base and columns of all causes."""
        self.catalogue = catalogue
        self.index = noise.index(catalogue.protocol)
        channels = noise.by_channel(catalogue.protocol, instruments or Instruments())
        self._noise = noise_matrix(self.index, channels)
        self.base = catalogue.vector(Truth())
        self.candidates = [
            made
            for cause in catalogue.causes.values()
            if catalogue.has(cause.name) and (made := self._candidate(cause)) is not None
        ]

    @cached_property
    def nuisances(self) -> np.ndarray:
        """(n, k) changes by one standard deviation of each."""
        found = []
        better = self.catalogue.protocol.known_better
        for name in NUISANCES:
            up, down = (self.catalogue.vector(Truth((), {name: way * STEP})) for way in (1, -1))
            found.append(better.get(name, 1.0) * (up - down) / (2 * STEP))
        return np.column_stack(found)

    def change(self, causes: Sequence[Hidden]) -> np.ndarray:
        """(n,) by causes, at the laboratory's own values of all nuisances."""
        return self.catalogue.vector(Truth(tuple(causes))) - self.base

    def _candidate(self, cause: Cause) -> Candidate | None:
        low, high = cause.range()
        second = high if high > 1.2 else low
        shapes: list[Shape] = []
        for form, each in enumerate(cause.forms):
            one = self.change([Hidden(cause.name, form, 1.0)])
            if abs(second - 1) > 0.1:
                other = self.change([Hidden(cause.name, form, second)])
                shapes.append(CurvedShape(one, each.label, (second, other)))
            else:
                shapes.append(Shape(one, each.label))
        if max(float(np.abs(shape.change).max()) for shape in shapes) < UNFELT:
            return None
        return Candidate(cause.name, tuple(shapes), cause.mean, cause.spread, cause.one_sided)

    def covariance(self, kept: np.ndarray) -> Covariance:
        """Of noise and nuisances, of the readings that are there."""
        columns = self.nuisances[kept]
        return Covariance.of(self._noise[np.ix_(kept, kept)] + columns @ columns.T)

    def analysis(self, kept: np.ndarray, thresholds: Thresholds | None = None) -> Analysis:
        """With the true columns of the readings that are there."""
        candidates = [
            Candidate(
                each.name,
                tuple(_those(shape, kept) for shape in each.shapes),
                each.mean, each.spread, each.one_sided,
            )
            for each in self.candidates
        ]  # fmt: skip
        std = np.sqrt(np.diag(self._noise))[kept]
        index = self.index[kept].reset_index(drop=True)
        known = thresholds or self.thresholds
        screen = CurvedScreen(candidates, self.covariance(kept))
        return Analysis(index, screen, std, WEIGHTS, known)

    @cached_property
    def thresholds(self) -> Thresholds:
        """Of the whole protocol; a reading that is missing hardly changes them.

        The bound's columns are exact, so that nothing unseen is allowed for.
        """
        whole = self.analysis(np.ones(len(self.index), dtype=bool), Thresholds())
        return of_analysis(whole.screen, whole.pairs, whole.unknown, whole.priors, unseen_sigma=0.0)

    def attained(self, case: Case, readings: Readings) -> Attained:
        """The verdict by exact evidence on the same draws."""
        kept = readings.kept
        analysis = self.analysis(kept)
        better = self.catalogue.protocol.known_better
        sigmas = np.array([case.truth.sigma(n) / better.get(n, 1.0) for n in NUISANCES])
        moved = self.nuisances @ sigmas
        change = self.change(case.truth.causes)
        residual = (change + moved + readings.noise)[kept]
        strengths = [
            float(np.linalg.norm(analysis.covariance.whiten(self.change([each])[kept])))
            for each in case.truth.causes
        ]
        white = analysis.covariance.whiten(change[kept])
        found = analysis.findings(residual)
        verdict = decide(
            found.posterior, analysis.screen, found.scores, found.pairs, analysis.thresholds
        )
        return Attained(
            verdict,
            self._intervals(case, verdict),
            self._cut(kept, change[kept], residual),
            tuple(strengths),
            unexplained(analysis, white),
        )

    def _intervals(self, case: Case, verdict: Verdict) -> tuple[Interval, ...]:
        if case.kind != "one" or case.hidden[0] not in verdict.names:
            return ()
        (hidden,) = case.truth.causes
        found = next(score.amplitude for score in verdict.scores if score.name == hidden.name)
        return (Interval(hidden.name, found.low, found.high, hidden.strength),)

    def _cut(self, kept: np.ndarray, change: np.ndarray, residual: np.ndarray) -> float:
        """Mean over what is left out, as the analyser leaves it out; 0 where nothing can be."""
        index = self.index[kept].reset_index(drop=True).assign(rate_kPa_per_s=np.nan)
        found = []
        for parts in folds(index).values():
            left = [
                (
                    part,
                    *(self._left(kept, part, values) for values in (residual, residual - change)),
                )
                for part in parts
            ]
            for channel in dict.fromkeys(index["channel"]):
                mine = (index["channel"] == channel).to_numpy()
                before = np.concatenate([errors[mine[part]] for part, errors, _ in left])
                after = np.concatenate([errors[mine[part]] for part, _, errors in left])
                found.append(1 - np.sqrt(np.mean(after**2) / np.mean(before**2)))
        return float(np.mean(found)) if found else 0.0

    def _left(self, kept: np.ndarray, part: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Errors on the readings ``part``, nuisances fitted to the others."""
        columns = self.nuisances[kept]
        seen = columns[~part]
        covariance = self._noise[np.ix_(kept, kept)][np.ix_(~part, ~part)] + seen @ seen.T
        fitted = seen.T @ np.linalg.solve(covariance, values[~part])
        return np.asarray(values[part] - columns[part] @ fitted)


def _those(shape: Shape, kept: np.ndarray) -> Shape:
    """The change of the readings that are kept."""
    if isinstance(shape, CurvedShape):
        strength, change = shape.second
        return CurvedShape(shape.change[kept], shape.label, (strength, change[kept]))
    return Shape(shape.change[kept], shape.label)


def unexplained(analysis: Analysis, white: np.ndarray) -> float:
    """Length (σ) of what the best single cause leaves of a whitened change (n,)."""
    curved = [s.second[1] for s in analysis.screen.shapes if isinstance(s, CurvedShape)]
    more = analysis.covariance.whiten(np.column_stack(curved)) if curved else white[:, None][:, :0]
    columns = np.hstack([analysis.screen.columns, more])
    length = np.linalg.norm(columns, axis=0)
    if not (length > 0).any():
        return float(np.linalg.norm(white))
    along = (columns[:, length > 0] / length[length > 0]).T @ white
    return float(np.sqrt(max(white @ white - float((along**2).max()), 0.0)))
