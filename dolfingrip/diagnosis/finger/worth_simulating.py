"""Which causes are simulated further: those that could be seen beside others.

A cause is simulated once at first. What it changes there, and its derivatives, may be taken in any
amount: that says the most that it can explain, alone and beside each other cause. Where that is too
little to be seen, no further simulation can tell of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from itertools import combinations

import numpy as np
import scipy.linalg

from dolfingrip.diagnosis.core.evidence import CovarianceModel
from dolfingrip.diagnosis.core.polynomial import SimulatedChanges, principal
from dolfingrip.diagnosis.core.problem import InferenceProblem, Subset
from dolfingrip.diagnosis.core.search import NONE, Key, levels
from dolfingrip.diagnosis.finger.model import plain_fit
from dolfingrip.diagnosis.policy import POLICY


def columns_of(simulated: SimulatedChanges, scale: np.ndarray) -> np.ndarray:
    """Return what a cause changes, and its derivatives, at the middle moduli, (n, k).

    Args:
        simulated: its simulations.
        scale: noise of the readings, shape (n,).
    """
    middle = len(simulated.values) // 2
    rows = np.vstack([simulated.values[middle], *np.moveaxis(simulated.slopes[middle], 1, 0)])
    rows = rows[np.isfinite(rows).all(axis=1)] / scale
    return np.asarray(principal(rows, len(rows)).T * scale[:, None])


def worth_simulating(
    plain: InferenceProblem, columns: Mapping[str, np.ndarray], finished: Set[str]
) -> set[str]:
    """The next causes to simulate further: each could be seen in a hypothesis that may be likely.

    A hypothesis may be likely where its largest likelihood is not hopelessly below that of any
    other. A cause is seen in it where the readings are so much better explained with it. Single
    causes come first, then pairs: these also mend what a first simulation of one of them misses.
    Last, what first simulations may miss counts, too.

    Args:
        plain: the model without causes.
        columns: what each cause changes, (n, k).
        finished: causes that have all their simulations.
    """
    explained, largest = _bounds(plain, columns)
    for count, share in ((1, 0.0), (2, 0.0), (2, POLICY.first_error)):
        tried = {each: value for each, value in largest.items() if len(each[0]) <= count}
        best = max(tried.values())
        found: set[str] = set()
        for (subset, size), value in tried.items():
            gain = explained[subset, size]
            known = tuple(name for name in subset if name in finished)
            missed = 0.5 * share**2 * (gain - explained[known, size])
            if value < best - POLICY.hopeless - missed:
                continue
            for name in set(subset) - finished:
                without = tuple(each for each in subset if each != name)
                by_chance = columns[name].shape[1]
                if gain - explained[without, size] > POLICY.visible_sigma**2 + by_chance:
                    found.add(name)
        if found:
            return found
    return set()


def _bounds(
    plain: InferenceProblem, columns: Mapping[str, np.ndarray]
) -> tuple[dict[Key, float], dict[Key, float]]:
    """How much χ² each hypothesis explains at most, and ln of its largest likelihood."""
    explained: dict[Key, float] = {}
    largest: dict[Key, float] = {}
    every: list[Subset] = [NONE, *((name,) for name in columns), *combinations(columns, 2)]
    for size, prior in levels(plain.policy).items():
        level = CovarianceModel(plain, size)
        rest, own = _about_fit(plain, level)
        rest = rest - own @ (own.T @ rest)
        beside = {}
        for name, each in columns.items():
            white = level.whitened(each)
            beside[name] = _basis(white - own @ (own.T @ white))
        alone = -0.5 * float(rest @ rest) - 0.5 * level.log_det + float(np.log(prior))
        for subset in every:
            gain = 0.0
            if subset:
                white_columns = np.hstack([beside[name] for name in subset])
                white_columns = white_columns if len(subset) == 1 else _basis(white_columns)
                gain = float(np.square(white_columns.T @ rest).sum())
            explained[subset, size] = gain
            largest[subset, size] = alone + 0.5 * gain
    return explained, largest


def _about_fit(plain: InferenceProblem, level: CovarianceModel) -> tuple[np.ndarray, np.ndarray]:
    """Return the residual without causes, (n,), and a basis of what the model may change; white."""
    zeta = plain_fit(plain, level).zeta
    here = plain.predicted(NONE, zeta)
    ways = []
    for step in np.diag(np.full(plain.nuisance_count, POLICY.parabola)):
        more, less = (plain.predicted(NONE, zeta + by * step) - here for by in (1.0, -1.0))
        ways += [more - less, more + less]
    return level.whitened(plain.value - here), _basis(level.whitened(np.column_stack(ways)))


def _basis(white: np.ndarray) -> np.ndarray:
    """Orthonormal columns of the same span, without ways that change nothing."""
    if not white.size:
        return white
    left, sizes, _ = scipy.linalg.svd(white, full_matrices=False)
    return np.asarray(left[:, sizes > 1e-8 * max(sizes[0], 1e-300)])
