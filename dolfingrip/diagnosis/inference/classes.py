"""Classes of effects that the readings cannot tell apart.

At a strength of s standard deviations, an effect in whose place another is fitted leaves
½ s² (1 − cos²θ) in log likelihood, θ the angle between their whitened changes. Two effects
where this is below ln 20 are tied. Ties are not transitive: e may be tied to f and f to g, but
not e to g. Classes are the connected parts of the graph of ties, so a tied pair is never parted;
the price is that e and g are then reported together, too. Where effects have one sign, opposite
changes are no tie.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.screen import Score

TIED = float(np.log(20))
"""Expected log Bayes factor below which two effects are not told apart."""


def cosines(scores: Sequence[Score], one_sided: npt.NDArray[np.bool_]) -> Matrix:
    """cos θ between candidates' changes, never negative; shape (candidates, candidates).

    Args:
        scores: of the candidates, with the directions of their best shapes.
        one_sided: shape (candidates,); an effect of two signs is turned the way that fits.
    """
    directions = np.column_stack([score.direction for score in scores])
    return _feasible(directions.T @ directions, one_sided)


def cosines_beside(
    scores: Sequence[Score], one_sided: npt.NDArray[np.bool_], other: int, tau: float
) -> Matrix:
    """The same where another effect of unknown strength is there, too.

    Args:
        scores, one_sided: see :func:`cosines`.
        other: number of the other candidate, whose own row and column mean nothing.
        tau: spread of its strength times the length of its change, in standard deviations.
    """
    directions = np.column_stack([score.direction for score in scores])
    gram = directions.T @ directions
    gram -= tau**2 / (1 + tau**2) * np.outer(gram[other], gram[other])
    length = np.sqrt(np.maximum(np.diag(gram), 1e-12))
    return _feasible(gram / np.outer(length, length), one_sided)


def separation(strength_sigma: float, cosine: npt.ArrayLike) -> Vector:
    """Expected log Bayes factor ½ s² (1 − cos²θ) between effects."""
    return np.asarray(0.5 * strength_sigma**2 * (1 - np.asarray(cosine) ** 2))


def partition(cosine: Matrix, strength_sigma: float, among: Sequence[int]) -> list[tuple[int, ...]]:
    """Classes of the candidates ``among``, numbers in ascending order.

    Args:
        cosine: shape (candidates, candidates).
        strength_sigma: of the fitted effect.
        among: candidates to join; others make no ties.
    """
    if not among:
        return []
    chosen = np.asarray(among, dtype=int)
    tied = separation(strength_sigma, cosine[np.ix_(chosen, chosen)]) < TIED
    count, label = connected_components(csr_array(tied), directed=False)
    return [tuple(int(i) for i in chosen[label == k]) for k in range(count)]


def _feasible(gram: Matrix, one_sided: npt.NDArray[np.bool_]) -> Matrix:
    both = one_sided[:, None] & one_sided[None, :]
    return np.asarray(np.where(both, np.maximum(gram, 0.0), np.abs(gram)))
