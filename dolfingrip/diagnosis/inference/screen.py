"""The screen: evidence of each candidate alone, over all its shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.special import softmax

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector, log_mean_exp, unit
from dolfingrip.diagnosis.inference.candidate import Candidate
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.evidence import Amplitude, amplitude, log_bayes_factor

FAINTEST = 0.5
"""Strength (σ) at an ordinary draw from the prior below which an effect cannot be seen."""


@dataclass(frozen=True)
class Score:
    """What the readings say about one candidate alone.

    Attributes:
        name: of the candidate.
        log_evidence: ln of the Bayes factor against no effect.
        strength_sigma: length of the fitted change, in standard deviations.
        score_sigma: z of the most probable shape.
        shape: number of the most probable shape.
        shape_weights: of all shapes, sum 1.
        amplitude: strength at the most probable shape, by the ordinary one.
        visible: whether an ordinary strength can be seen in these readings at all.
        direction: whitened change of the most probable shape, of length 1 (0 where it changes
            nothing), shape (n,).
        notes: what to beware of, a sentence each.
    """

    name: str
    log_evidence: float
    strength_sigma: float
    score_sigma: float
    shape: int
    shape_weights: tuple[float, ...]
    amplitude: Amplitude
    visible: bool
    direction: Vector = field(repr=False, compare=False)
    notes: tuple[str, ...] = ()


class Screen:
    """Candidates, whitened once, and their evidence for any residuals.

    Attributes:
        candidates: as given.
        covariance: of the residual without an effect.
        columns: whitened changes at ordinary strength of all shapes, shape (n, shapes).
        owner: number of the candidate of each shape, shape (shapes,).
        length: of the columns, shape (shapes,).
        mean, spread, one_sided: of the prior of the candidate of each shape, shape (shapes,).
        visible: of each candidate, shape (candidates,).
    """

    def __init__(self, candidates: Sequence[Candidate], covariance: Covariance) -> None:
        self.candidates = tuple(candidates)
        self.covariance = covariance
        pairs = [(i, s) for i, candidate in enumerate(candidates) for s in candidate.shapes]
        self.owner = np.array([i for i, _ in pairs], dtype=int)
        self.shapes = tuple(shape for _, shape in pairs)
        changes = [shape.change for shape in self.shapes]
        stacked = np.column_stack(changes) if changes else np.zeros((len(covariance), 0))
        self.columns: Matrix = covariance.whiten(stacked)
        self.length: Vector = np.linalg.norm(self.columns, axis=0)
        self.mean = np.array([candidates[i].mean for i in self.owner])
        self.spread = np.array([candidates[i].spread for i in self.owner])
        self.one_sided = np.array([candidates[i].one_sided for i in self.owner], dtype=bool)
        ordinary = self.length * np.hypot(self.mean, self.spread)
        self.visible: npt.NDArray[np.bool_] = np.array(
            [ordinary[self.owner == i].max() >= FAINTEST for i in range(len(candidates))],
            dtype=bool,
        )

    def score_sigma(self, whitened: Matrix) -> Matrix:
        """z of each shape for whitened residuals of shape (n, m), shape (shapes, m)."""
        safe = np.where(self.length > 0, self.length, 1.0)
        return np.asarray(self.columns.T @ whitened / safe[:, None])

    def shape_evidence(self, whitened: Matrix) -> Matrix:
        """ln BF of each shape for whitened residuals of shape (n, m), shape (shapes, m)."""
        return log_bayes_factor(
            self.length[:, None],
            self.score_sigma(whitened),
            self.mean[:, None],
            self.spread[:, None],
            self.one_sided[:, None],
        )

    def by_candidate(self, shape_logs: Matrix) -> Matrix:
        """ln of the mean over each candidate's shapes: (…, shapes, m) to (…, candidates, m)."""
        if not self.candidates:
            return np.zeros((*shape_logs.shape[:-2], 0, shape_logs.shape[-1]))
        # shapes of one candidate follow one another
        count = np.bincount(self.owner)
        total = np.logaddexp.reduceat(shape_logs, np.cumsum(count) - count, axis=-2)
        return np.asarray(total - np.log(count)[:, None])

    def log_evidence(self, whitened: Matrix) -> Matrix:
        """ln BF of each candidate for whitened residuals (n, m), shape (candidates, m)."""
        return self.by_candidate(self.shape_evidence(whitened))

    def scores(self, whitened: Vector) -> list[Score]:
        """What a whitened residual, shape (n,), says about each candidate."""
        logs = self.shape_evidence(whitened[:, None])[:, 0]
        z = self.score_sigma(whitened[:, None])[:, 0]
        return [self._score(i, logs, z) for i in range(len(self.candidates))]

    def draw_change(self, i: int, rng: np.random.Generator) -> Vector:
        """A whitened change by candidate ``i``, strength and shape from the prior, shape (n,)."""
        number, strength = self.candidates[i].draw(rng)
        shape = int(np.flatnonzero(self.owner == i)[number])
        return strength * self.columns[:, shape]

    def _score(self, i: int, logs: Vector, z: Vector) -> Score:
        candidate = self.candidates[i]
        numbers = np.flatnonzero(self.owner == i)
        weights = softmax(logs[numbers])
        best = int(numbers[weights.argmax()])
        prior = (self.mean[best], self.spread[best], bool(self.one_sided[best]))
        fitted = amplitude(self.length[best], float(z[best]), *prior)
        return Score(
            name=candidate.name,
            log_evidence=float(log_mean_exp(logs[numbers])),
            strength_sigma=float(np.linalg.norm(fitted.mean * self.columns[:, best])),
            score_sigma=float(z[best]),
            shape=int(weights.argmax()),
            shape_weights=tuple(float(weight) for weight in weights),
            amplitude=fitted,
            visible=bool(self.visible[i]),
            direction=unit(self.columns[:, best]),
            notes=self._notes(i),
        )

    def _notes(self, i: int) -> tuple[str, ...]:
        if self.visible[i]:
            return ()
        return (f"{self.candidates[i].name} cannot be seen in these readings",)
