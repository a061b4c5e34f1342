"""How strongly readings feel a cause, with the model's own numbers left free and without."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dolfingrip.diagnosis.core.evidence import CovarianceModel
from dolfingrip.diagnosis.core.problem import InferenceProblem
from dolfingrip.diagnosis.core.search import NONE
from dolfingrip.diagnosis.core.unknown import Cause, Unknown


@dataclass(frozen=True, eq=False)
class Visibility:
    """Changes of the readings by causes.

    Attributes:
        problem: the readings.
        at: ζ of the model's own numbers, shape (own,).
    """

    problem: InferenceProblem
    at: np.ndarray

    @cached_property
    def columns(self) -> CovarianceModel:
        """All columns without a discrepancy."""
        return CovarianceModel(self.problem, 0.0)

    @cached_property
    def own(self) -> np.ndarray:
        """Changes by the model's own numbers, for each standard deviation, shape (n, own)."""
        return self.problem.slopes(NONE, self.at)

    def change(self, name: str, zeta: np.ndarray) -> np.ndarray:
        """Return the change of the readings by a cause at ζ, shape (n,)."""
        with_it = self.problem.predicted((name,), np.r_[self.at, zeta])
        return np.asarray(with_it - self.problem.predicted(NONE, self.at))

    def strength(self, name: str, zeta: np.ndarray) -> float:
        """Length of a cause's change, the model's own numbers left free, standard deviations."""
        white = self.columns.whitened(self.change(name, zeta))
        rest = white - self.columns.whitened(self.own) @ taken(
            white, self.columns.whitened(self.own)
        )
        return float(np.sqrt(max(white @ rest, 0.0)))


def taken(change: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """How much of a change other numbers take over, in standard deviations of each, shape (k,).

    Args:
        change: of the readings, by their noise, shape (n,).
        columns: changes by one standard deviation of each number, shape (n, k). Their priors let
            them follow as far as that.
    """
    inner = columns.T @ columns + np.eye(columns.shape[1])
    return np.asarray(np.linalg.solve(inner, columns.T @ change))


def start_and_step(cause: Cause, number: Unknown) -> tuple[float, float]:
    """The value at which an amplitude does nothing, and from there to the ordinary one."""
    start = cause.neutral(number)
    step = number.prior.mean - start
    if abs(step) <= 1e-9 * number.prior.spread:
        step = number.prior.spread if number.bounds[1] > start else -number.prior.spread
    return start, step


def at_strength(
    cause: Cause, box: np.ndarray, strength: float = 1.0, rng: np.random.Generator | None = None
) -> np.ndarray:
    """ζ of a cause's numbers at a strength; those of its shape from their priors, or their middles.

    Args:
        cause: the effect.
        box: ranges of ζ, shape (d, 2).
        strength: by the ordinary one.
        rng: draws the shape; None for the middles.
    """
    found = []
    for number, (low, high) in zip(cause.numbers, box, strict=True):
        if number.amplitude:
            start, step = start_and_step(cause, number)
            value = start + strength * step
            zeta = low if number.prior.positive and value <= 0 else number.zeta(value)
        else:
            zeta = 0.0 if rng is None else float(rng.standard_normal())
        found.append(np.clip(zeta, low, high))
    return np.array(found)
