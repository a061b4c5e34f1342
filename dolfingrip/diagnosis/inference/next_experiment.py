"""Which experiment would tell tied effects apart, per minute of the laboratory's time.

If effect e is there at its fitted strength a, fitting f in its place leaves ½ s² sin²θ in log
likelihood, s = ‖L⁻¹ a v_e‖ and θ between L⁻¹v_e and L⁻¹v_f: the expected log Bayes factor. An
addition is worth what it adds to that, over the readings so far and its own together, whose
nuisances they share.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.covariance import Covariance

ENOUGH = 20.0
"""Log Bayes factor beyond which more decides nothing more."""


@dataclass(frozen=True, eq=False)
class Addition:
    """An experiment that could be added.

    Attributes:
        name: of it.
        minutes: that it takes.
        changes: of its own m readings by each effect, at the same strength as those of the
            readings so far, shape (m,) each, by name.
        covariance: of the readings so far and its own, in this order, n + m.
    """

    name: str
    minutes: float
    changes: Mapping[str, Vector]
    covariance: Covariance

    def __post_init__(self) -> None:
        """Check the time.

        Raises:
            ValueError: one line naming the addition and its time.
        """
        if not self.minutes > 0:
            raise ValueError(f"{self.name}: minutes = {self.minutes}: allowed: above 0")


@dataclass(frozen=True)
class Worth:
    """What an addition is worth.

    Attributes:
        name: of the addition.
        minutes: that it takes.
        gain: expected increase of the log Bayes factor between tied effects, averaged over which of
            them is there.
        gain_per_minute: the same, each pair counted up to ``enough``, by the minute.
        by_pair: expected log Bayes factor with the addition, of the first against the second
            where the first is there.
    """

    name: str
    minutes: float
    gain: float
    gain_per_minute: float
    by_pair: Mapping[tuple[str, str], float]


def expected_log_bayes_factor(true: Vector, other: Vector, strength: float = 1.0) -> float:
    """½ s² sin²θ if ``true`` is there, against ``other``.

    Args:
        true, other: whitened changes, shape (n,) each.
        strength: by which ``true`` is multiplied.
    """
    squared = float(other @ other)
    along = float(true @ other) ** 2 / squared if squared > 0 else 0.0
    return 0.5 * strength**2 * max(float(true @ true) - along, 0.0)


def rank_additions(
    additions: Sequence[Addition],
    covariance: Covariance,
    changes: Mapping[str, Vector],
    strengths: Mapping[str, float],
    probabilities: Mapping[str, float],
    enough: float = ENOUGH,
) -> list[Worth]:
    """Additions in the order of what they are worth per minute, the best first.

    Args:
        additions: that could be made.
        covariance: of the n readings so far.
        changes: of these by each tied effect, at a strength of 1, shape (n,) each, by name.
        strengths: fitted, by name.
        probabilities: of each tied effect, by name; only ratios count.
        enough: log Bayes factor up to which each pair of effects counts.
    """
    names = list(changes)
    before = _matrix(covariance, [changes[name] for name in names], names, strengths)
    weights = _weights(names, probabilities)
    found = []
    for addition in additions:
        joined = [np.concatenate([changes[name], addition.changes[name]]) for name in names]
        after = _matrix(addition.covariance, joined, names, strengths)
        useful = np.minimum(after, enough) - np.minimum(before, enough)
        found.append(
            Worth(
                name=addition.name,
                minutes=addition.minutes,
                gain=float((weights * (after - before)).sum()),
                gain_per_minute=float((weights * useful).sum() / addition.minutes),
                by_pair={
                    (e, f): float(after[i, j])
                    for i, e in enumerate(names)
                    for j, f in enumerate(names)
                    if i != j
                },
            )
        )
    return sorted(found, key=lambda worth: -worth.gain_per_minute)


def _matrix(
    covariance: Covariance,
    changes: Sequence[Vector],
    names: Sequence[str],
    strengths: Mapping[str, float],
) -> Matrix:
    """Expected log Bayes factor if the row's effect is there, against the column's."""
    white = covariance.whiten(np.column_stack(changes))
    return np.array(
        [
            [
                expected_log_bayes_factor(white[:, i], white[:, j], strengths[e])
                for j in range(len(names))
            ]
            for i, e in enumerate(names)
        ]
    )


def _weights(names: Sequence[str], probabilities: Mapping[str, float]) -> Matrix:
    """Probability that the row's effect is there and the column's is its rival; sum 1."""
    p = np.array([probabilities[name] for name in names], dtype=float)
    weights = np.outer(p, p)
    np.fill_diagonal(weights, 0.0)
    total = weights.sum()
    if total > 0:
        return np.asarray(weights / total)
    count = len(names)
    return (np.ones((count, count)) - np.eye(count)) / max(count * (count - 1), 1)
