"""What would settle what the readings leave open: further tests, and checks of single numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import batched

import numpy as np
from scipy.linalg import block_diag

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.additions.checks import NumberCheck, checks, coupon_check
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.additions.worth import Comparison, Rival, chance_alone, tied
from dolfingrip.diagnosis.answer.analysis import Analysis, remembers_state
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.core.fitting import MapFit
from dolfingrip.diagnosis.core.problem import NONE
from dolfingrip.diagnosis.core.unknown import expected
from dolfingrip.diagnosis.data.measurement import shows_memory
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.files.diagnosis import Advice, NextExperiment, Way
from dolfingrip.jobs.run import Say


def settled_by(
    diagnosis: Diagnosis, say: Say, *, simulating: bool
) -> tuple[list[NextExperiment], list[str]]:
    """Weigh what tells the hypotheses apart that the answer leaves open, the best first.

    Args:
        diagnosis: up to its answer.
        say: told what is being done.
        simulating: whether tests are weighed, too, which have to be simulated.

    Returns:
        What helps, and why some could not be weighed, a sentence each.
    """
    analysis, open_ = diagnosis.analysis, _open(diagnosis)
    if len(open_) < 2:
        return [], []
    problem, fits = analysis.problem, [fit for _, fit in open_]
    level = diagnosis.decision.best.level if diagnosis.decision.answer == "unknown" else 0.0
    covariance = problem.covariance + level**2 * problem.kernel
    comparison = Comparison(
        analysis.measurement, analysis.errors.noise,
        block_diag(covariance, np.diag(np.square(problem.told_std))),
        np.array([p for p, _ in open_]),
        [_rival(analysis, fit, *problem.every_reading(fit.subset, fit.zeta)) for fit in fits],
        problem.policy, problem.elastic,
    )  # fmt: skip
    factor = analysis.factor(diagnosis.decision.best)
    possible = (
        checks(analysis.applied, EXPERIMENTS["coupon"].parts) if analysis.closed_form
        else [*checks(analysis.applied), coupon_check(problem.policy, factor)]
    )  # fmt: skip
    weighed = [_checked(analysis, comparison, check, fits) for check in possible]
    now = chance_alone(comparison.probability, comparison.apart)
    helpful = [test for test in weighed if test is not None and (test.chance > now or test.tells)]
    failed: list[str] = []
    compared = fits
    if not (analysis.closed_form or diagnosis.decision.answer == "cause"):
        # simulations are made of what no check tells from the likeliest
        told_apart = {name for check in helpful for name in check.tells}
        left = [fit for fit in fits[1:] if told_apart.isdisjoint(problem.causes(fit.subset))]
        compared = [fits[0], *left[: problem.policy.leading - 1]]
    simulating &= len(compared) > 1
    tests = proposals(analysis.measurement, diagnosis.config) if simulating else []
    at_once = max(len(tests), 1) if analysis.closed_form else 1
    for together in batched(tests, at_once, strict=False):
        say(f"next experiment: {'; '.join(test.name for test in together)}")
        try:
            expectations = analysis.expected(compared, together)
        except ConfigError as error:
            failed += [f"{test.name} could not be judged: {error}" for test in together]
            continue
        for test, expectation in zip(together, expectations, strict=True):
            if expectation is None:
                why = "a simulation of a likely cause does not reach all readings"
                failed.append(f"{test.name} could not be judged: {why}")
            else:
                simulated = dict(zip(map(id, compared), expectation[0], strict=True))
                weighed_test = _tested(analysis, comparison, test, fits, simulated, expectation[1])
                helpful.append(weighed_test)
    return sorted(helpful, key=lambda worth: worth.rank), failed


def _open(diagnosis: Diagnosis) -> list[tuple[float, MapFit]]:
    """Hypotheses that could each be the answer, the most probable first."""
    posterior, decision = diagnosis.posterior, diagnosis.decision
    if decision.answer == "cause":
        return tied(posterior, decision)
    if decision.answer == "none":
        others = [(other.factor, other.stronger) for other in diagnosis.alternatives]
        return [(1.0, diagnosis.none), *others]
    total, policy = posterior.by_causes, posterior.problem.policy
    likely, least = [NONE, *(other.fit.subset for other in diagnosis.alternatives)], 0.0
    if not diagnosis.alternatives:
        likely, least = [*total], policy.matters * max(total.values())
    likely = sorted((s for s in likely if total[s] > least), key=lambda s: -total[s])
    most = len(diagnosis.alternatives) or policy.leading
    return [(total[s], posterior.best(s)) for s in likely[:most]]


def _rival(analysis: Analysis, fit: MapFit, readings: np.ndarray, slopes: np.ndarray) -> Rival:
    problem = analysis.problem
    acting, count = frozenset(problem.causes(fit.subset)), problem.nuisance_count
    change = problem.predicted(fit.subset, fit.zeta) - problem.predicted(NONE, fit.zeta[:count])
    return Rival(fit.zeta, readings, slopes, acting, count, change)


def _tested(
    analysis: Analysis,
    comparison: Comparison,
    proposal: Proposal,
    fits: Sequence[MapFit],
    simulated: Mapping[int, tuple[np.ndarray, np.ndarray]],
    others: np.ndarray,
) -> NextExperiment:
    """Weigh a test by simulations of hypotheses; the rig's own errors are others then.

    One that is not simulated counts as the first one: the test tells nothing of it.
    """
    readings, slopes = simulated[id(fits[0])]
    after = []
    for fit in fits:
        alike = np.zeros((len(readings), len(fit.zeta)))
        count = min(slopes.shape[1], analysis.problem.nuisance_count)
        alike[:, :count] = slopes[:, :count]
        after.append(_rival(analysis, fit, *simulated.get(id(fit), (readings, alike))))
    # along one loading a law with memory follows any elastic one, fitted anew
    seen = shows_memory(analysis.measurement, proposal.measurement)
    remembers = np.array([any(map(remembers_state, rival.acting)) for rival in after])
    unseen = (remembers[:, None] != remembers) & (not seen)
    errors = comparison.errors(proposal, after[0].readings)
    return comparison.worth(proposal, after, errors, others, unseen)


def _checked(
    analysis: Analysis, comparison: Comparison, check: NumberCheck, fits: Sequence[MapFit]
) -> NextExperiment | None:
    """Weigh a check of single numbers; None where no hypothesis is about any of them."""
    unknowns = analysis.problem.unknowns
    after = [
        _rival(analysis, fit, *expected(check.readings, unknowns(fit.subset), fit.zeta))
        for fit in fits
    ]
    if not any(rival.slopes.any() for rival in after):
        return None
    return comparison.worth(check, after, np.diag(np.square(check.std)))


def advice(diagnosis: Diagnosis) -> Advice | None:
    """Advise what to do next where nothing that was weighed tells all that is open.

    Args:
        diagnosis: with what was weighed.

    Returns:
        None where what was weighed does.
    """
    decision, analysis = diagnosis.decision, diagnosis.analysis
    coupons, names = analysis.closed_form, diagnosis.tied
    settled = {name for test in diagnosis.next for name in test.tells}
    if diagnosis.next and not decision.by_shape and settled.issuperset(names):
        return None
    memory_seen = shows_memory(analysis.measurement)
    names = [name for name in names if name not in settled]
    acting = [*names, *decision.first, *decision.second]
    unload = not memory_seen and any(map(remembers_state, acting))
    way: Way = "finger" if coupons else "nothing" if diagnosis.claimed else "alone"
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
    elif decision.answer == "none" and way == "alone":
        way = "other_channel"
    if way == "alone":
        likely = (name for name, p in decision.inclusion.items() if p >= diagnosis.policy.matters)
        names = [*dict.fromkeys([*decision.first, *decision.second, *likely])]
    return Advice(way=way, names=tuple(names), unload=unload)
