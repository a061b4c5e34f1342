"""From probabilities to an answer: which causes, how sure, and what share stays unexplained.

The answer is tried under other priors: other odds of two causes, wider priors of numbers.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from scipy.special import softmax

from dolfingrip.diagnosis.core.covariance import CovarianceModel, taken
from dolfingrip.diagnosis.core.fitting import MapFit
from dolfingrip.diagnosis.core.problem import NONE, InferenceProblem, Subset
from dolfingrip.diagnosis.core.search import ModelPosterior
from dolfingrip.diagnosis.core.unknown import mixture
from dolfingrip.diagnosis.policy import Policy


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Answers under other priors.

    Attributes:
        answers: by what is other about the priors, that of the policy's own priors first.
        probability: of the policy's answer under each: of one member of each of its sets.
    """

    answers: Mapping[str, Decision]
    probability: Mapping[str, float]

    @property
    def least(self) -> float:
        """The smallest of these probabilities."""
        return min(self.probability.values())


OWN = "as reported"

LAW_MISSES: Final = 0.01
"""Part of the largest reading that any elastic law misses of a material, root mean square.

Laws that miss less are not told apart.
"""


def sensitivity(posterior: ModelPosterior) -> tuple[Decision, Sensitivity]:
    """The answer, and what it is under other priors.

    A second cause is named only where it is more probable than not under each of them. That no
    effect does it is as probable as under the prior that speaks most against it: an effect may be
    stronger than was thought, and the end of its range is no finding.
    """
    problem = posterior.problem
    pairs = np.array([len(problem.causes(fit.subset)) == 2 for fit in posterior.fits])
    by_odds = pairs * np.log(2)
    changes = {
        "two causes half as likely": -by_odds,
        "two causes twice as likely": by_odds,
    }
    tails = [problem.tail(fit.subset) for fit in posterior.fits]
    for by in problem.policy.widths:
        wider = _wider(posterior.fits, tails, by, problem.policy.rare)
        changes[f"priors {by:g} times as wide"] = wider
    decision = decide(posterior)
    others = {name: decide(_reweighted(posterior, logs)) for name, logs in changes.items()}
    answers = {OWN: decision, **others}
    if decision.second and min(_of(answer, decision) for answer in answers.values()) <= 0.5:
        least = {
            names: min(held(answer.subsets, names) for answer in answers.values())
            for side in (decision.first, decision.second)
            if (names := tuple(name for name in side if name in posterior.names))
        }
        decision = decide(posterior, alone=max(least, key=least.__getitem__))
    varied = Sensitivity(answers, {name: _of(answer, decision) for name, answer in answers.items()})
    if decision.answer == "unknown":
        decision = replace(decision, probability=min(decision.probability, varied.least))
    return decision, varied


def _of(other: Decision, decision: Decision) -> float:
    """Probability of an answer by other probabilities."""
    if decision.answer == "none":
        return other.none
    if decision.answer == "unknown":
        return other.discrepancy if decision.nearest else other.unknown
    return min(held(other.subsets, decision.first, decision.second), 1 - other.unexplained)


def _wider(
    fits: Sequence[MapFit], tails: Sequence[np.ndarray], by: float, rare: float = Policy().rare
) -> np.ndarray:
    """Changes of ln evidence where the priors of the causes' numbers are wider, (fits,) (Laplace).

    Args:
        fits: of hypotheses; those of as many numbers are worked out side by side.
        tails: of these priors, shape (d,) for each fit.
        by: factor of their widths.
        rare: probability of their wide part.
    """
    alike, changes = defaultdict[tuple[int, int], list[int]](list), np.empty(len(fits))
    for place, (fit, tail) in enumerate(zip(fits, tails, strict=True)):
        alike[len(fit.zeta), len(tail)].append(place)
    for (size, d), places in alike.items():
        zeta = np.array([fits[place].zeta for place in places])
        last = slice(size - d, size)
        hessian = np.array([fits[place].hessian for place in places])
        tail = np.array([tails[place] for place in places])
        (old, stiff), (new, soft) = (mixture(zeta[:, last] / w, tail, rare) for w in (1.0, by))
        relaxed = np.zeros_like(zeta)
        relaxed[:, last] = stiff - soft / by**2
        pull, looser = relaxed * zeta, hessian - relaxed[..., None] * np.eye(size)
        # the numbers follow where the prior pulls less
        followed = (pull * np.linalg.solve(looser, pull[..., None])[..., 0]).sum(axis=1)
        determinants = np.linalg.slogdet(looser)[1] - np.linalg.slogdet(hessian)[1]
        changes[places] = (old - new).sum(axis=1) + 0.5 * (followed - determinants)
        changes[places] -= d * np.log(by)
    return changes


def _reweighted(posterior: ModelPosterior, logs: np.ndarray) -> ModelPosterior:
    with np.errstate(divide="ignore"):
        return replace(posterior, probability=softmax(np.log(posterior.probability) + logs))


Answer = Literal["cause", "none", "unknown"]


@dataclass(frozen=True, eq=False)
class Decision:
    """The answer of the readings.

    Attributes:
        answer: a cause is named, nothing is to be seen, or the catalogue explains little.
        first: causes that the readings cannot tell apart, the most probable first.
        second: of a second cause; empty where none is named.
        nearest: causes that would be named if they left less; empty where they are.
        probability: of the answer; of causes the less, the more stays beside them.
        inclusion: probability that each cause takes part and is visible.
        none: probability that nothing is to be seen.
        unknown: probability that something is off of which no visible cause takes part.
        unexplained: share of what the configured model misses that stays, 0 to 1.
        discrepancy: probability that something stays beside the causes.
        subsets: probability of each set of visible causes.
        best: the most probable fit that the answer is about.
        by_shape: whether a cause with memory is named that readings tell by a shape alone, which an
            elastic curve with friction in the rig has, too.
        nuisance_only: whether nothing is named but a nuisance of the model, or causes that do as
            well.
    """

    answer: Answer
    first: tuple[str, ...]
    second: tuple[str, ...]
    nearest: tuple[str, ...]
    probability: float
    inclusion: dict[str, float]
    none: float
    unknown: float
    unexplained: float
    discrepancy: float
    subsets: dict[Subset, float]
    best: MapFit
    nuisance_only: bool
    by_shape: bool = False


def decide(posterior: ModelPosterior, *, alone: tuple[str, ...] = ()) -> Decision:
    """The answer of a posterior.

    Implausible numbers of the rig stand beside the causes, not in their place: a set of causes
    holds effects; a number of the rig is named second where nearly all hypotheses have it, and
    first where no effect is.

    Something that the catalogue lacks may look like one of its causes. What stays beside them tells
    how alike the two are: the more stays, the less probable the causes can be, either of two sets
    by the share of what the other leaves. The answer is unknown where they explain less than half.

    Args:
        posterior: probabilities of all hypotheses.
        alone: the only set that may be named; any one or two where empty.
    """
    problem, policy = posterior.problem, posterior.problem.policy
    mass = posterior.by(lambda fit: fit.visible)
    laws = _laws_alike(posterior)
    by_effects = posterior.by(
        lambda fit: _as_one(problem.causes(fit.visible) or fit.visible, laws)[:2]
    )
    none = posterior.by(lambda fit: fit.shows_nothing).get(True, 0.0)
    discrepancy = posterior.by(lambda fit: fit.level > 0).get(True, 0.0)
    inclusion = {
        name: sum(p for subset, p in mass.items() if name in subset) for name in posterior.names
    }

    def with_laws(names: tuple[str, ...]) -> tuple[str, ...]:
        every = (*names, *laws[1:]) if {*laws[:1]} & {*names} else names
        kept = _by_shape(posterior, every)
        return kept if held(mass, kept) >= policy.claimed else every

    first, second = (alone, NONE) if alone else map(
        with_laws, _sets(by_effects, inclusion, posterior.strengths, policy.credible)
    )  # fmt: skip
    claim = held(mass, first, second)
    if second and claim < policy.nearly:  # one set is surer than two
        first, second = with_laws(_smallest(by_effects, inclusion, policy.credible)), ()
        claim = held(mass, first)
    rig = max(problem.rig - {*first}, key=inclusion.__getitem__, default=None)
    if first and not second and not alone and rig and inclusion[rig] >= policy.credible:
        second = (rig,)
    if second:
        most = {one: _at_most(_stays(posterior, one, other), policy.doubt)
                for one, other in ((first, second), (second, first))}  # fmt: skip
        claim = min(held(mass, first, second), *most.values())
        if claim < policy.nearly:  # the surer one
            first, second = max(most, key=lambda one: held(mass, one) * most[one]), ()
            claim = held(mass, first)
    unexplained, unknown = _stays(posterior), mass.get(NONE, 0.0) - none
    answer: Answer = "cause"
    probability = claim
    if none >= policy.claimed:
        answer, probability = "none", none
    elif not first or claim < policy.claimed:
        answer, probability = ("none", none) if none > unknown else ("unknown", unknown)
    nearest: tuple[str, ...] = ()
    if answer == "cause":
        probability = min(claim, _at_most(unexplained, policy.doubt))
        if 1 - unexplained < 0.5:
            answer, probability, nearest = "unknown", discrepancy, first
            unknown = max(unknown, discrepancy)
    if answer != "cause":
        first, second = (), ()
    nothing = answer == "none"
    best = posterior.best(NONE, level=0.0) if nothing else _leading(posterior, first, second)
    by_shape = not _beyond_a_curve(posterior, best, first)
    if by_shape:
        probability = min(probability, 0.5)
    elif not _beyond_a_curve(posterior, best, second):  # the first is claimed without it
        second, probability = (), min(held(mass, first), _at_most(unexplained, policy.doubt))
    nuisance_only = not second and not problem.implausible.keys().isdisjoint(first)
    return Decision(
        answer, _all_names(problem, first), _all_names(problem, second), nearest,
        float(probability), inclusion, none, float(unknown), unexplained, discrepancy, mass, best,
        nuisance_only, by_shape,
    )  # fmt: skip


def _laws_alike(posterior: ModelPosterior) -> tuple[str, ...]:
    """Elastic laws that follow the readings as closely as any law is true, the likeliest first.

    They do much, and what is left of the readings tells them apart no more. There are none where
    the model may do without any cause and follows as closely, as then no law is asked for.
    """
    problem, likely = posterior.problem, dict[str, float]()
    none = posterior.best(NONE, level=0.0)
    may_do = posterior.by(lambda fit: fit.shows_nothing).get(True, 0.0)
    follows = problem.share(problem.left(none.subset, none.zeta)) <= LAW_MISSES
    if follows and may_do > 1 - problem.policy.credible:
        return ()
    for p, fit in posterior.weighed:
        laws = [name for name in problem.causes(fit.subset) if name in problem.elastic]
        if len(laws) != 1 or fit.level > 0 or fit.subset != problem.causes(fit.subset):
            continue
        (law,) = laws
        count = problem.nuisance_count
        change = problem.change(law, fit.zeta[:count], fit.zeta[count:])
        much = problem.share(change) > LAW_MISSES
        if much and problem.share(problem.left(fit.subset, fit.zeta)) <= LAW_MISSES:
            likely[law] = max(p, likely.get(law, 0.0))
    return tuple(sorted(likely, key=lambda law: -likely[law]))


def _as_one(names: Subset, alike: tuple[str, ...]) -> Subset:
    """Names in which the first of those that are alike stands for each of them."""
    return tuple(dict.fromkeys(alike[0] if name in alike else name for name in names))


def _by_shape(posterior: ModelPosterior, names: tuple[str, ...]) -> tuple[str, ...]:
    """A set without causes with memory that an elastic curve does as well as, if others are left.

    Args:
        posterior: of all hypotheses.
        names: of the set.
    """
    memory = tuple(name for name in names if name in posterior.problem.remembering)
    best = _leading(posterior, memory, NONE)
    if len(memory) == len(names) or _beyond_a_curve(posterior, best, memory):
        return names
    return tuple(name for name in names if name not in memory)


def _beyond_a_curve(posterior: ModelPosterior, best: MapFit, names: tuple[str, ...]) -> bool:
    """Tell if a set of causes does more than an elastic curve or friction in the rig would.

    A loading at one rate, or the loop of a coupon, shows memory by its shape alone. An elastic law
    or friction may have that shape. So causes with memory are told there if these in their place do
    not follow the readings as well.

    Args:
        posterior: of all hypotheses.
        best: with one of the causes.
        names: of the set.
    """
    problem = posterior.problem
    if problem.curves is None or not names or not problem.remembering.issuperset(names):
        return True
    others = tuple(name for name in problem.causes(best.subset) if name not in names)
    without = posterior.best(others, level=best.level)
    curves = np.pad(problem.curves, ((0, len(problem.told)), (0, 0)))
    model = problem.levels[best.level]
    beside = CovarianceModel(model.covariance + curves @ curves.T, model.columns)
    readings, slopes = problem.every_reading(without.subset, without.zeta)
    off, free = map(beside.whitened, (problem.every_value - readings, slopes))
    left = off - free @ taken(off, free)  # all other numbers follow
    return 0.5 * (float(left @ left) - best.misfit) > problem.policy.log_odds


def _all_names(problem: InferenceProblem, names: tuple[str, ...]) -> tuple[str, ...]:
    """With all that a factor of the model's own may be."""
    place = problem.implausible
    return tuple(
        member for name in names
        for member in (problem.always[place[name]].names if name in place else (name,))
    )  # fmt: skip


def held(mass: dict[Subset, float], first: tuple[str, ...], second: tuple[str, ...] = ()) -> float:
    """Probability that a member of each set takes part."""
    return sum(p for subset, p in mass.items() if _meets(subset, first, second))


def _meets(subset: Subset, first: tuple[str, ...], second: tuple[str, ...]) -> bool:
    """Tell if causes have a member of the first set, and of the second where there is one."""
    return bool({*subset} & {*first}) and (not second or bool({*subset} & {*second}))


def _sets(
    mass: dict[Subset, float],
    inclusion: dict[str, float],
    strength: dict[str, float],
    credible: float,
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The sets of causes that stand for one another; the second is empty where one cause will do.

    Two causes are named where two act more probably than not. Then each pair of causes has one in
    either set.
    """
    pairs = {subset: p for subset, p in mass.items() if len(subset) > 1}
    if sum(pairs.values()) <= 0.5:
        return _smallest(mass, inclusion, credible), ()
    sides: tuple[dict[str, float], dict[str, float]] = ({}, {})
    seen, total = 0.0, sum(pairs.values())
    for (a, b), p in sorted(pairs.items(), key=lambda pair: -pair[1]):
        if seen >= credible * total:
            break
        seen += p
        one, other = sides
        turned = (a in other) + (b in one) > (a in one) + (b in other)
        if not sides[0]:
            turned = inclusion[b] > inclusion[a]
        for name, side in ((b, 0), (a, 1)) if turned else ((a, 0), (b, 1)):
            if name not in sides[1 - side]:
                sides[side][name] = sides[side].get(name, 0.0) + p
    sets = [tuple(sorted(side, key=lambda name: -side[name])) for side in sides]
    sets.sort(key=lambda names: -strength.get(names[0], 0.0))
    return sets[0], sets[1]


def _smallest(
    mass: dict[Subset, float], inclusion: dict[str, float], credible: float
) -> tuple[str, ...]:
    """The fewest causes of which nearly all subsets have one, the most telling first.

    Each next one is in most of what those before it are not in (greedy cover; Chvátal, Mathematics
    of Operations Research 4, 1979).
    """
    left = {subset: p for subset, p in mass.items() if subset}
    total = sum(left.values())
    cover: list[str] = []
    while sum(left.values()) > (1 - credible) * total:
        share: dict[str, float] = defaultdict(float)
        for subset, p in left.items():
            for name in subset:
                share[name] += p
        cover.append(max(share, key=lambda name: (share[name], inclusion[name])))
        left = {subset: p for subset, p in left.items() if cover[-1] not in subset}
    return tuple(cover)


def _leading(posterior: ModelPosterior, first: tuple[str, ...], second: tuple[str, ...]) -> MapFit:
    """The most probable fit, summed over levels, of causes that the answer names."""

    def allowed(fit: MapFit) -> bool:
        named = _meets(fit.visible, first, second) if first else not fit.visible
        return named and fit.visible == fit.subset

    masses = posterior.by(lambda fit: (allowed(fit), fit.subset))
    total = {subset: p for (named, subset), p in masses.items() if named}
    if not total:
        return posterior.best(NONE)
    # what is told of the answer is of one of each set, and of causes that it names, where these do
    causes, named = posterior.problem.causes, {*first, *second}
    least = posterior.problem.policy.matters * max(total.values())
    single = [
        s for s, p in total.items()
        if p >= least and all(len({*s} & {*names}) < 2 for names in (first, second))
    ]  # fmt: skip
    within = [s for s in single if named >= {*causes(s)}]
    return posterior.best(max(within or single or total, key=lambda subset: total[subset]))


def _at_most(stays: float, doubt: float) -> float:
    """The largest probability of causes beside which so large a share stays."""
    return float((1 - stays) ** doubt)


def _stays(
    posterior: ModelPosterior, names: tuple[str, ...] = (), beside: tuple[str, ...] = ()
) -> float:
    """Share of χ² that stays, where a discrepancy is on, of what is missed without causes.

    Args:
        posterior: probabilities of all hypotheses.
        names: of what is missed without one of these; all causes where empty.
        beside: pairs with one of these alone are asked; all hypotheses where empty.
    """
    problem = posterior.problem
    n, causes = len(problem.value) + len(problem.told), problem.causes
    off: dict[Subset, float] = {}
    for fit in posterior.fits:
        if fit.level == 0:
            acting = causes(fit.subset)
            off[acting] = min(fit.misfit - n, off.get(acting, np.inf))
    share, total = 0.0, 0.0
    for p, fit in posterior.weighed:
        acting = causes(fit.subset)
        if names and not _meets(fit.subset, names, beside):
            continue
        total += p
        missed = off[tuple(name for name in acting if names and name not in names)]
        if fit.subset and not acting:  # what is missed with the model's own numbers as told
            missed = posterior.as_reported - n
        if fit.level > 0 and missed > 0:
            share += p * float(np.clip(off[acting] / missed, 0.0, 1.0))
    return share / total if total else 1.0
