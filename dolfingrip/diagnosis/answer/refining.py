"""Which hypothesis is simulated next: one rule for coupons and fingers, from the first to the last.

Readings at a fit are extrapolated from the nearest simulation. That may miss a part of the change
from there, and so some ln of evidence. An error of an instrument follows from the simulation that
is there, and is worked out always; it is nearly linear in the model's own numbers, and so only
those of the last simulation count. Of others, the hypothesis whose probability that could change
most is simulated at its fit, until no change could matter. It can gain no more than half of what
its χ² exceeds that of the most probable one, or the number of readings where that is less. At
last, each cause of the most probable pair is simulated alone, at the pair's numbers and at its own
fit, whatever it may miss; that of a coupon is simulated all over its prior from the start.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.core.fitting import MapFit
from dolfingrip.diagnosis.core.problem import InferenceProblem, Subset
from dolfingrip.diagnosis.core.search import ModelPosterior, search
from dolfingrip.jobs.run import Say


def refined(
    analysis: Analysis, posterior: ModelPosterior, say: Say, most: int
) -> tuple[Analysis, ModelPosterior]:
    """Simulate hypotheses at their fits until no extrapolated one could matter.

    Args:
        analysis: the readings with the first simulations.
        posterior: of all hypotheses by these.
        say: told what is being done.
        most: hypotheses that are simulated, at most.

    Returns:
        The analysis with all simulations, and its posterior.
    """
    tried, made = Counter[Subset](), 0
    while True:
        free, others = doubtful(analysis, posterior, tried)
        fits = free or others[: min(analysis.simulation.at_once, most - made)]
        if not fits:
            break
        made += 0 if free else len(fits)
        names = [" with ".join(fit.subset) or "the model" for fit in fits]
        say(f"simulating {', '.join(names)} at {'its' if len(fits) == 1 else 'their'} best numbers")
        problem, changed = analysis.problem, []
        for fit, tangents in zip(fits, analysis.simulated(fits, free=bool(free)), strict=True):
            causes = problem.causes(fit.subset)
            tried[causes] += 1
            if tangents is None:
                problem = problem.without(causes)
                continue
            if not free and not problem.displaying.isdisjoint(causes):
                before = {of: run for of, run in problem.runs.items() if of != causes}
                problem = replace(problem, runs=before)
            problem = problem.beside([(causes, tangents)])
            changed.append(causes)
        analysis = replace(analysis, problem=problem)
        posterior = search(
            problem, np.random.default_rng(0), sample=False, before=posterior, changed=changed
        )
    return analysis, posterior


def doubtful(
    analysis: Analysis, posterior: ModelPosterior, tried: Counter[Subset]
) -> tuple[list[MapFit], list[MapFit]]:
    """List fits that simulations may change.

    Args:
        analysis: the readings.
        posterior: of all hypotheses.
        tried: simulations of each set of causes so far.

    Returns:
        Those whose simulation costs nothing, and others, those first that could be likeliest.
    """
    problem, free = posterior.problem, dict[Subset, MapFit]()
    could: dict[Subset, tuple[float, MapFit]] = {}
    fewer: dict[Subset, MapFit] = {}
    alone = posterior.alone
    probability, policy = {id(fit): p for p, fit in posterior.weighed}, problem.policy
    leading = posterior.leaders(lambda fit: fit.level)
    for fit in posterior.leaders(lambda fit: (problem.causes(fit.subset), fit.level)).values():
        causes, p = problem.causes(fit.subset), probability[id(fit)]
        left = policy.tries - tried[causes]
        costs = analysis.free(fit) is None
        if causes in problem.impossible or left + (0 if costs else policy.tries) <= 0:
            continue
        if not costs and left > 0:
            if extrapolated(problem, fit) > policy.exactly:
                free.setdefault(causes, fit)
            continue
        closest = min(leading[fit.level].misfit, len(problem.every_value))
        gain = max(0.5 * (fit.misfit - closest), 0.0)
        if p <= policy.matters and gain <= np.log1p(policy.matters / (p + np.finfo(float).tiny)):
            continue
        missed = extrapolated(problem, fit)
        hope = np.log(p + np.finfo(float).tiny) + min(missed, gain)
        change = float(max(np.exp(min(hope, 100.0)) - p, -p * np.expm1(-missed)))
        if change > max(policy.matters, could.get(causes, (0.0, fit))[0]):
            could[causes] = change, fit
        elif causes in alone and not analysis.closed_form and tried[causes] < policy.tries:
            of_pair = replace(fit, zeta=alone[causes])
            if extrapolated(problem, of_pair) > policy.exactly:
                fewer.setdefault(causes, of_pair)
            elif missed > policy.exactly:
                fewer.setdefault(causes, fit)
    others = [fit for _, fit in sorted(could.values(), key=lambda pair: -pair[0])]
    return list(free.values()), others or list(fewer.values())


def extrapolated(problem: InferenceProblem, fit: MapFit) -> float:
    """ln of evidence that a fit's readings may miss, as they are not simulated.

    The readings change by some length, in standard deviations, from those simulated of the same
    causes that are nearest; a part of the length may be wrong.

    Args:
        problem: with the simulations.
        fit: of one of its hypotheses.
    """
    causes = problem.causes(fit.subset)
    here = problem.predicted(fit.subset, fit.zeta)
    if causes in problem.runs:
        zeta = fit.zeta[problem.simulated_count : problem.nuisance_count]
        off = here - problem.linear @ zeta - problem.runs[causes].told[..., 0]
        off = off[np.argmin(np.square(off / problem.noise).sum(axis=1))]
    else:  # two causes that were not simulated together, by the weaker one
        every = []
        for name, places in problem.places(fit.subset).items():
            fewer = tuple(other for other in fit.subset if other != name)
            every.append(here - problem.predicted(fewer, np.delete(fit.zeta, places)))
        off = min(every, key=lambda change: float(np.square(change / problem.noise).sum()))
    length, policy = float(np.linalg.norm(problem.levels[fit.level].whitened(off))), problem.policy
    return 0.5 * min(policy.first_error * length, 2 * policy.unlikely) ** 2
