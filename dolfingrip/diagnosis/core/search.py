"""All hypotheses of up to two causes, with and without a discrepancy, and their probabilities.

Beside each the model's own numbers are as told, or far from it where the readings ask for that.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, pairwise
from math import comb
from typing import Final

import numpy as np

from dolfingrip.diagnosis.core.covariance import taken
from dolfingrip.diagnosis.core.fitting import SETTLED, Hypotheses, MapFit
from dolfingrip.diagnosis.core.problem import NONE, InferenceProblem, Key, Subset

KEPT: Final = 1e-6
"""Probability of causes by all readings from which on they are tried again with some of them."""

SMALL: Final = 0.01
"""Largest level of a discrepancy that pairs of causes are chosen under."""

SAMPLED: Final = 0.01
"""Probability from which on a hypothesis is sampled."""


@dataclass(frozen=True, eq=False)
class ModelPosterior:
    """Probabilities of all hypotheses.

    Attributes:
        problem: the readings.
        fits: of each hypothesis, by causes and level.
        probability: of each, in the same order.
        log_density: ln p(y), averaged over all.
        as_reported: χ² of the model without causes, its own numbers as told.
        modes: fits by causes and level before draws told more of them.
        coarse: fits of pairs by causes and level, from which the likeliest were chosen.
    """

    problem: InferenceProblem
    fits: Sequence[MapFit]
    probability: np.ndarray
    log_density: float
    as_reported: float
    modes: Mapping[Key, Sequence[MapFit]] = field(default_factory=dict)
    coarse: Mapping[Key, MapFit] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """All causes that some reading feels, and the model's own numbers."""
        return *self.problem.numbers, *self.problem.implausible

    @property
    def weighed(self) -> Iterator[tuple[float, MapFit]]:
        """Each hypothesis' fit with its probability."""
        return zip(map(float, self.probability), self.fits, strict=True)

    def by[K](self, of: Callable[[MapFit], K]) -> dict[K, float]:
        """Probability of all hypotheses that have something in common, by what it is."""
        total: dict[K, float] = defaultdict(float)
        for p, fit in self.weighed:
            total[of(fit)] += p
        return dict(total)

    @property
    def subsets(self) -> dict[Subset, float]:
        """Probability of each set of causes, at any level."""
        return self.by(lambda fit: fit.subset)

    @property
    def by_causes(self) -> dict[Subset, float]:
        """Probability of each set of causes, whatever numbers of the model are implausible."""
        return self.by(lambda fit: self.problem.causes(fit.subset))

    @property
    def alone(self) -> dict[Subset, np.ndarray]:
        """Numbers of the most probable pair without one of its causes, by the other; none else."""
        _, best = max(self.weighed, key=lambda pair: pair[0])
        places = self.problem.places(best.subset)
        return {
            (name,): np.delete(best.zeta, places[other])
            for name in places for other in places if other != name
        }  # fmt: skip

    @property
    def strengths(self) -> dict[str, float]:
        """Strength of each name in the most probable fit that has it."""
        strengths: dict[str, float] = {}
        for _, fit in sorted(self.weighed, key=lambda pair: pair[0]):
            strengths |= dict(zip(fit.subset, fit.strengths, strict=True))
        return strengths

    def best(self, subset: Subset, *, level: float | None = None) -> MapFit:
        """The most probable fit of these causes, at one level or at any.

        The model's own numbers may be implausible by the prior.
        """
        causes = self.problem.causes
        if level is None:
            return self.leaders(lambda fit: causes(fit.subset))[causes(subset)]
        return self.leaders(lambda fit: (causes(fit.subset), fit.level))[causes(subset), level]

    def leaders[K](self, of: Callable[[MapFit], K]) -> dict[K, MapFit]:
        """The most probable fits of those that have something in common, by what it is."""
        leaders: dict[K, MapFit] = {}
        for _, fit in sorted(self.weighed, key=lambda pair: -pair[0]):
            leaders.setdefault(of(fit), fit)
        return leaders


def search(
    problem: InferenceProblem,
    rng: np.random.Generator,
    *,
    sample: bool = True,
    before: ModelPosterior | None = None,
    changed: Collection[Subset] = (),
) -> ModelPosterior:
    """The posterior over all hypotheses of a problem.

    A pair of causes is left out where even its largest likelihood is far below the best evidence,
    or where coarse fits tell that others are likelier.

    Args:
        problem: the readings.
        rng: of samples.
        sample: whether likely hypotheses are sampled.
        before: the posterior of the same readings, with fewer simulations.
        changed: sets of causes that were simulated since; fits without any are those of before.
    """
    levels, names = problem.policy.levels, tuple(problem.numbers)
    modes: dict[Key, Sequence[MapFit]] = {}
    zeta: dict[Key, np.ndarray] = {}

    def unchanged[T](earlier: Mapping[Key, T]) -> dict[Key, T]:
        return {
            (causes, level): fits for (causes, level), fits in earlier.items()
            if not any({*causes} >= {*acting} for acting in changed)
        }  # fmt: skip

    kept = {} if before is None else unchanged(before.modes)
    kept_coarse = {} if before is None else unchanged(before.coarse)

    def fit(starts: Mapping[Key, Sequence[np.ndarray]]) -> None:
        missing = {key: places for key, places in starts.items() if key not in kept}
        fits = kept | _fits(problem, missing, SETTLED)
        for above, level in pairwise(sorted(levels, reverse=True)):
            # a large discrepancy has fewer local minima
            lower = {
                (causes, at): [_likeliest_mode(fits[causes, above]).zeta, *places]
                for (causes, at), places in missing.items()
                if at == level and (causes, above) in fits
                and _misses_less(problem, fits[causes, above], fits[causes, at])
            }  # fmt: skip
            fits |= _fits(problem, lower, SETTLED)
        for key in starts:
            modes[key] = fits[key]
            zeta[key] = _likeliest_mode(fits[key]).zeta

    alone = {} if before is None else before.alone
    fit({(NONE, level): [np.zeros(problem.nuisance_count)] for level in levels})
    fit({
        ((name,), level): [
            *(np.r_[zeta[NONE, level], start] for start in _starts(problem, name)),
            *([alone[name,]] if (name,) in alone else []),
        ]
        for name in names for level in levels
    })  # fmt: skip
    best = max(mode.log_evidence for fits in modes.values() for mode in fits)
    pairs: list[Subset] = [*combinations(names, 2)]
    hopeful: dict[Subset, list[float]] = defaultdict(list)
    for level in levels if pairs else ():
        most = Hypotheses(problem, pairs).largest(level)
        for place in np.flatnonzero(most >= best - problem.policy.hopeless):
            hopeful[pairs[place]].append(level)
    starts = {pair: _starts_of_pair(problem, pair, zeta) for pair in pairs if pair in hopeful}
    coarse = _coarse(problem, starts, kept_coarse)
    # the share that stays is counted without a discrepancy
    fit({
        (pair, level): starts[pair]
        for pair in _likeliest(coarse, problem.policy.most_fits)
        for level in dict.fromkeys([0.0, *hopeful[pair]])
    })  # fmt: skip
    every_fit = [mode for fits in modes.values() for mode in fits]
    weighed = _weighed(problem, every_fit, rng if sample else None)
    return replace(weighed, modes=modes, coarse=coarse)


def _likeliest_mode(modes: Sequence[MapFit]) -> MapFit:
    return max(modes, key=lambda mode: mode.log_evidence)


def _misses_less(
    problem: InferenceProblem, others: Sequence[MapFit], modes: Sequence[MapFit]
) -> bool:
    """Tell if fits under another discrepancy have numbers that follow the readings better."""
    other, mode = map(_likeliest_mode, (others, modes))
    off = problem.every_value - problem.every_reading(other.subset, other.zeta)[0]
    missed = float(np.square(problem.levels[mode.level].whitened(off)).sum())
    return missed < mode.misfit - 2 * problem.policy.log_odds


def _fits(
    problem: InferenceProblem, starts: Mapping[Key, Sequence[np.ndarray]], settled: float
) -> dict[Key, list[MapFit]]:
    """Fits of causes with the model's own numbers as told, and with those far that may be so.

    A number that is far is fitted where that is not much less probable, by the fit without it.
    """
    policy, fits = problem.policy, {key: list[MapFit]() for key in starts}
    if not starts:
        return fits
    hypotheses = Hypotheses(problem, [causes for causes, _ in starts])
    fresh = starts
    while fresh:
        new, fresh = hypotheses.fits(fresh, settled), {}
        for fit in new:
            causes = problem.causes(fit.subset)
            fits[causes, fit.level].append(fit)
            for name, place in problem.implausible.items():
                far = [other for other in problem.implausible if other in {name, *fit.subset}]
                key = (*causes, *far), fit.level
                have = name in fit.subset or key in fresh
                wide = problem.always[place].prior.wide
                if not have and _log_odds_of_implausible(fit, place, wide, policy.rare) >= np.log(
                    policy.matters
                ):
                    fresh[key] = [fit.zeta, *starts[causes, fit.level]]
    return fits


def _log_odds_of_implausible(fit: MapFit, place: int, wide: float, rare: float) -> float:
    """ln of the odds that one of the model's own numbers is far rather than as told (Laplace)."""
    relaxed = 1 - wide**-2
    left = 1 - relaxed * float(np.linalg.inv(fit.hessian)[place, place])
    gain = 0.5 * relaxed * float(fit.zeta[place]) ** 2 / left - 0.5 * np.log(left)
    return gain - float(np.log(wide)) + float(np.log(rare))


def pursued(
    posterior: ModelPosterior, columns: np.ndarray, log_prior: np.ndarray, of: np.ndarray
) -> list[int]:
    """Find the columns with which the readings would be most probable; none where none helps.

    Beside each hypothesis columns are added one after the other, each where it raises the evidence
    most: a matching pursuit (Mallat & Zhang, IEEE Trans. Signal Process. 41, 1993). All else that
    the hypothesis fits is linear about its fit. For a column c and what the fit leaves, r, both
    whitened and after all that the fit may follow,

        ln p(r | c) − ln p(r) = ½ (cᵀr)² / (1 + cᵀc) − ½ ln(1 + cᵀc)

    Args:
        posterior: of all hypotheses without them.
        columns: changes of the readings, by one standard deviation of each, shape (n, k).
        log_prior: ln of the odds that each acts, shape (k,).
        of: what each is a column of, shape (k,); one of these at most acts.
    """
    if not columns.shape[1]:
        return []
    problem, white = posterior.problem, dict[float, np.ndarray]()
    policy, prior = problem.policy, problem.policy.levels
    logs = [fit.log_evidence + float(np.log(prior[fit.level])) for fit in posterior.fits]
    best, most = list[int](), max(logs)
    for fit, log in sorted(zip(posterior.fits, logs, strict=True), key=lambda pair: -pair[1]):
        if log + 0.5 * fit.misfit <= most:
            continue  # more than all that is missed cannot be gained
        model = problem.levels[fit.level]
        if fit.level not in white:
            white[fit.level] = model.whitened(columns)
        readings, slopes = problem.every_reading(fit.subset, fit.zeta)
        residual, count = problem.every_value - readings, len(problem.value)
        added, free = white[fit.level], model.whitened(slopes[:count])
        off = model.whitened(residual[:count]) + free @ fit.zeta
        chosen: list[int] = []
        for _ in range(policy.leading):
            beside = np.column_stack([free, added[:, chosen]])
            follow = taken(added, beside)
            size = np.einsum("nk,nk->k", added, added) - ((beside.T @ added) * follow).sum(axis=0)
            pull = off @ added - (off @ beside) @ follow
            gain = 0.5 * pull**2 / (1 + size) - 0.5 * np.log1p(size) + log_prior
            gain[np.isin(of, of[chosen])] = -np.inf
            place = int(np.argmax(gain))
            if gain[place] <= policy.log_odds:
                break
            chosen.append(place)
            log += float(gain[place])
        if log > most:
            best, most = chosen, log
    return best


def searched_again(problem: InferenceProblem, of_all: ModelPosterior) -> ModelPosterior:
    """The posterior over causes that were likely before, and parts of likely pairs, by Laplace.

    Args:
        problem: the same, with some of the readings.
        of_all: of all readings; fits begin at its numbers.
    """
    likely = [{*subset} for subset, p in of_all.subsets.items() if not subset or p > KEPT]
    starts = {
        (fit.subset, fit.level): [fit.zeta]
        for fit in of_all.fits if any({*fit.subset} <= causes for causes in likely)
    }  # fmt: skip
    hypotheses = Hypotheses(problem, [subset for subset, _ in starts])
    return _weighed(problem, hypotheses.fits(starts), None)


def _weighed(
    problem: InferenceProblem, fits: list[MapFit], rng: np.random.Generator | None
) -> ModelPosterior:
    """Probabilities by evidence and prior.

    An effect of the catalogue acts, or several do; each number of rig and finger is far from what
    was told, or is not.
    """
    policy, prior = problem.policy, problem.policy.levels
    count = len(problem.numbers)
    by_size = [p / max(comb(count, size), 1) for size, p in enumerate(policy.prior_by_size)]

    def weights(all_fits: list[MapFit]) -> tuple[np.ndarray, float]:
        sizes = [len(problem.causes(fit.subset)) for fit in all_fits]
        logs = np.array([
            -np.inf if problem.causes(fit.subset) in problem.impossible
            else fit.log_evidence + np.log(prior[fit.level] * by_size[size])
            + np.log(policy.rare) * (len(fit.subset) - size)
            for size, fit in zip(sizes, all_fits, strict=True)
        ])  # fmt: skip
        total = float(np.logaddexp.reduce(logs))
        return np.exp(logs - total), total

    probability, total = weights(fits)
    if rng is not None:
        fits = [
            Hypotheses(problem, [fit.subset]).sampled(fit, rng) if p > SAMPLED else fit
            for p, fit in zip(probability, fits, strict=True)
        ]
        probability, total = weights(fits)
    (as_reported,) = Hypotheses(problem, [NONE]).misfit(np.zeros((1, problem.nuisance_count)), 0.0)
    return ModelPosterior(problem, fits, probability, total, float(as_reported))


def _starts(problem: InferenceProblem, name: str) -> list[np.ndarray]:
    box = np.array([[number.low, number.high] for number in problem.numbers[name]])
    start = problem.policy.start
    ways = [(0, 0.0), *((i, way * start) for i in range(len(box)) for way in (-1, 1))]
    return [np.clip(way * np.eye(len(box))[i], *box.T) for i, way in ways]


def _starts_of_pair(
    problem: InferenceProblem, pair: Subset, zeta: Mapping[Key, np.ndarray]
) -> list[np.ndarray]:
    """Where fits of two causes start: at the fit of one beside a weak other, and at both."""
    n = problem.nuisance_count
    one, other = (zeta[(name,), 0.0] for name in pair)
    weak = [_starts(problem, name)[0] for name in pair]
    return [np.r_[one, other[n:]], np.r_[one, weak[1]], np.r_[other[:n], weak[0], other[n:]]]


def _coarse(
    problem: InferenceProblem,
    starts: Mapping[Subset, Sequence[np.ndarray]],
    kept: Mapping[Key, MapFit],
) -> dict[Key, MapFit]:
    """Coarse fits of pairs of causes under small discrepancies, but for those that are kept."""
    keys = [(pair, level) for level in problem.policy.levels if level <= SMALL for pair in starts]
    missing = {(pair, level): starts[pair] for pair, level in keys if (pair, level) not in kept}
    fits = Hypotheses(problem, [NONE, *starts]).fits(missing, 0.1 * problem.policy.exactly)
    new = dict(zip(missing, fits, strict=True))
    return {key: kept.get(key) or new[key] for key in keys}


def _likeliest(coarse: Mapping[Key, MapFit], most: int) -> list[Subset]:
    """The likeliest pairs under any small discrepancy, so many of each."""
    by_level = defaultdict[float, list[MapFit]](list)
    for (_, level), fit in coarse.items():
        by_level[level].append(fit)
    likeliest: dict[Subset, None] = {}
    for fits in by_level.values():
        order = sorted(fits, key=lambda fit: -fit.log_evidence)
        likeliest |= dict.fromkeys(fit.subset for fit in order[:most])
    return list(likeliest)
