"""What would settle what the readings leave open: further tests, and checks of single numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.additions.worth import (
    INSTRUMENTS,
    Comparison,
    NumberCheck,
    Rival,
    chance_alone,
    checks,
    tied,
)
from dolfingrip.diagnosis.answer.analysis import Analysis, remembers_state
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.core.evidence import NONE, MapFit
from dolfingrip.diagnosis.core.unknown import MODULUS
from dolfingrip.diagnosis.data.measurement import shows_memory
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.files.diagnosis import Advice, NextExperiment, Way
from dolfingrip.jobs.run import Say
from dolfingrip.parameter.nuisances import changes


def settled_by(
    found: Diagnosis, say: Say, *, simulating: bool
) -> tuple[list[NextExperiment], list[str]]:
    """Weigh what tells the hypotheses apart that the answer leaves open, the best first.

    Args:
        found: the diagnosis up to its answer.
        say: told what is being done.
        simulating: whether tests are weighed, too, which have to be simulated.

    Returns:
        What helps, and why some could not be weighed, a sentence each.
    """
    analysis, open_ = found.analysis, _open(found)
    if len(open_) < 2:
        return [], []
    problem, fits = analysis.problem, [fit for _, fit in open_]
    level = found.decision.best.level if found.decision.answer == "unknown" else 0.0
    comparison = Comparison(
        analysis.measurement, analysis.errors.noise,
        problem.covariance + level**2 * problem.kernel,
        np.array([p for p, _ in open_]),
        [
            _rival(analysis, fit, problem.predicted(fit.subset, fit.zeta),
                   problem.slopes(fit.subset, fit.zeta))
            for fit in fits
        ],
    )  # fmt: skip
    possible = INSTRUMENTS if analysis.closed_form else checks(analysis.applied)
    weighed = [_checked(analysis, comparison, each, fits) for each in possible]
    now = chance_alone(comparison.probability, comparison.apart)
    helpful = [each for each in weighed if each is not None and (each.chance > now or each.tells)]
    failed: list[str] = []
    for proposal in proposals(analysis.measurement, found.config) if simulating else ():
        say(f"next experiment: {proposal.name}")
        try:
            helpful.append(_tested(analysis, comparison, proposal, fits))
        except ConfigError as error:
            failed.append(f"{proposal.name} could not be judged: {error}")
    return sorted(helpful, key=lambda worth: worth.rank), failed


def _open(found: Diagnosis) -> list[tuple[float, MapFit]]:
    """Hypotheses that could each be the answer, the most probable first."""
    posterior, decision = found.posterior, found.decision
    if decision.answer == "cause":
        return tied(posterior, decision)
    if decision.answer == "none":
        rest = [(each.factor, each.stronger) for each in found.alternatives]
        return [(1.0, found.none), *rest]
    total = posterior.by_causes
    likely, least = [NONE, *(each.fit.subset for each in found.alternatives)], 0.0
    if not found.alternatives:
        likely, least = [*total], POLICY.rival * max(total.values())
    likely = sorted((each for each in likely if total[each] > least), key=lambda each: -total[each])
    most = len(found.alternatives) or POLICY.compared
    return [(total[each], posterior.best(each)) for each in likely[:most]]


def _rival(analysis: Analysis, fit: MapFit, readings: np.ndarray, slopes: np.ndarray) -> Rival:
    problem = analysis.problem
    acting, own = frozenset(problem.causes(fit.subset)), problem.nuisance_count
    change = problem.predicted(fit.subset, fit.zeta) - problem.predicted(NONE, fit.zeta[:own])
    return Rival(fit.zeta, readings, slopes, acting, own, change)


def _tested(
    analysis: Analysis, comparison: Comparison, proposal: Proposal, fits: Sequence[MapFit]
) -> NextExperiment:
    """Weigh a test by simulations of all hypotheses; the rig's own errors are others then.

    Raises:
        ConfigError: one line, where a simulation does not reach all readings.
    """
    expected = analysis.expected(fits, proposal)
    if expected is None:
        raise ConfigError("a simulation of a likely cause does not reach all readings")
    after = [_rival(analysis, fit, *own) for fit, own in zip(fits, expected, strict=True)]
    shared, cross = analysis.covariances(proposal, after[0].readings)
    # along one loading a law with memory follows any elastic one, fitted anew
    seen = shows_memory(analysis.measurement, proposal.measurement)
    remembers = np.array([any(map(remembers_state, each.acting)) for each in after])
    unseen = (remembers[:, None] != remembers) & (not seen)
    own = comparison.errors(proposal, after[0].readings) + shared
    return comparison.worth(proposal, after, own, cross, unseen)


def _checked(
    analysis: Analysis, comparison: Comparison, check: NumberCheck, fits: Sequence[MapFit]
) -> NextExperiment | None:
    """Weigh a check of single numbers; None where no hypothesis is about any of them."""
    after = [_checked_rival(analysis, check, fit) for fit in fits]
    if not any(each.slopes.any() for each in after):
        return None
    own = np.diag(np.square(check.std))
    cross = np.zeros((len(analysis.problem.value), len(check.std)))
    for each in analysis.errors.shared:
        read = check.read(changes(analysis.applied, each.name, each.std))
        own += np.outer(read, read)
        cross += np.outer(each.change, read)
    return comparison.worth(check, after, own, cross)


def _checked_rival(analysis: Analysis, check: NumberCheck, fit: MapFit) -> Rival:
    """A hypothesis at the readings of a check, by how far its numbers are from doing nothing."""
    problem, zeta = analysis.problem, fit.zeta
    numbers = [(each, place, float(each.at(0.0))) for place, each in enumerate(problem.always)]
    numbers += [(each, place, cause.neutral(each)) for cause, each, place in analysis.numbers(fit)]
    readings = np.zeros(len(check.std))
    slopes = np.zeros((len(check.std), len(zeta)))
    for number, place, start in numbers:
        read = check.read({number.key: 1.0})
        if number.key == MODULUS:  # by its logarithm
            readings += read * problem.factor.log_std * zeta[place]
            slopes[:, place] = read * problem.factor.log_std
        else:
            readings += read * (float(number.at(zeta[place])) - start)
            slopes[:, place] = read * number.slope(float(zeta[place]))
    return _rival(analysis, fit, readings, slopes)


def advice(found: Diagnosis) -> Advice | None:
    """Advise what to do next where nothing that was weighed tells all that is open.

    Args:
        found: the diagnosis, with what was weighed.

    Returns:
        None where what was weighed does.
    """
    decision, analysis = found.decision, found.analysis
    coupons, names = analysis.closed_form, found.tied
    told = {name for test in found.next for name in test.tells}
    if found.next and not decision.by_shape and told.issuperset(names):
        return None
    memory_seen = shows_memory(analysis.measurement)
    names = [name for name in names if name not in told]
    acting = [*names, *decision.first, *decision.second]
    unload = not memory_seen and any(map(remembers_state, acting))
    way: Way = "finger" if coupons else "nothing" if found.claimed else "alone"
    if decision.by_shape and coupons and memory_seen:
        way = "empty_machine"
    elif decision.by_shape and not coupons:
        way = "memory"
    elif decision.nuisance_only and coupons:
        way = "area"
    elif coupons and unload and decision.answer == "cause":
        way = "loop"
    elif names:
        way = "finger_or_channel" if coupons else "coupon_or_channel"
    elif decision.answer == "unknown":
        way = "rates" if coupons else "other_channel"
    elif decision.answer == "none":
        way = "finger" if coupons else "nothing"
    if way == "alone":
        likely = (name for name, p in decision.inclusion.items() if p >= POLICY.verified)
        names = [*dict.fromkeys([*decision.first, *decision.second, *likely])]
    return Advice(way=way, names=tuple(names), unload=unload)
