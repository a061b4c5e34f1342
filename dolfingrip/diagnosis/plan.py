"""A plan: what a rig could name, and which addition buys most per minute.

Each effect is supposed in turn, at strengths from its prior. The evidence that its readings are
expected to give to it and to all others (:mod:`dolfingrip.diagnosis.additions.worth`), with a
discrepancy as probable as a diagnosis takes it to be, tells what a diagnosis would name. The share
of strengths at which it is this effect alone is the probability that it is named. One with memory
is not named alone where a loading at one rate tells it by a shape that an elastic law has, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from scipy.special import ndtri, softmax

from dolfingrip.config import NO_CHANGE, Change, Config, ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.additions.worth import Rival, expected_evidence
from dolfingrip.diagnosis.answer.analysis import Analysis, told_by_shape
from dolfingrip.diagnosis.core.fitting import Hypotheses
from dolfingrip.diagnosis.core.problem import NONE
from dolfingrip.diagnosis.core.unknown import Cause
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.measurement import Measurement, joined, shows_memory
from dolfingrip.diagnosis.diagnose import DiagnosisSettings
from dolfingrip.diagnosis.finger import FingerSimulation
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.screening import analyse, simulator_of
from dolfingrip.diagnosis.simulation.runner import Workers, staying
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.experiments.synthetic import NOISE
from dolfingrip.files.plan import AdditionWorth, EffectOutlook, PlanFile


def strengths(cause: Cause, policy: Policy) -> np.ndarray:
    """Strengths of a cause that are equally probable, by the ordinary one, rising.

    Args:
        cause: an effect of the catalogue.
        policy: how many.
    """
    first = next(number for number in cause.numbers if number.amplitude)
    values = first.at(ndtri((np.arange(policy.strengths) + 0.5) / policy.strengths))
    start, step = cause.start_and_step(first)
    return np.asarray(np.sort(np.abs(values - start) / abs(step)))


def outlooks(planned: Analysis) -> list[EffectOutlook]:
    """Find for each effect from which strength on it is named, the strongest first.

    Args:
        planned: the readings to be.
    """
    problem, listed = planned.problem, [EffectOutlook(effect=name) for name in planned.unseen]
    at_rest = np.zeros(problem.nuisance_count)
    shown = shows_memory(planned.measurement)
    by_shape = () if shown else told_by_shape(planned.causes, planned.measurement)
    for name, cause in planned.causes.items():
        by_ordinary, at = strengths(cause, problem.policy), cause.at_strength()
        zetas = [np.r_[at_rest, cause.at_strength(float(s))] for s in by_ordinary]
        true = np.column_stack([problem.predicted((name,), zeta) for zeta in zetas])
        rivals = _rivals(planned, problem.predicted((name,), np.r_[at_rest, at]))
        mass = _expected(planned, rivals, true)
        sets = [_named(row, problem.policy) for row in mass]
        alone = np.array([names == (name,) and name not in by_shape for names in sets])
        within = np.array([name in names for names in sets])
        ordinary = mass[int(np.argmin(np.abs(by_ordinary - 1.0)))]
        least = problem.policy.matters * ordinary[name]
        others = sorted(ordinary, key=lambda other: -ordinary[other])
        named = threshold(by_ordinary, alone)
        listed.append(EffectOutlook(
            effect=name, strength_sigma=problem.strength(name, at_rest, at), named_from=named,
            ordinary=", ".join(f"{n.key.rpartition('.')[2]} = {float(n.at(z)):.4g}"
                               for n, z in zip(cause.numbers, at, strict=True)),
            named_from_sigma=None if named is None
            else problem.strength(name, at_rest, cause.at_strength(named)),
            class_from=threshold(by_ordinary, within), share=float(alone.mean()),
            class_share=float(within.mean()),
            confused_with=tuple(n for n in others if n not in ("", name) and ordinary[n] > least),
        ))  # fmt: skip
    return sorted(listed, key=lambda outlook: -outlook.strength_sigma)


def _rivals(planned: Analysis, value: np.ndarray) -> dict[str, Rival]:
    """Nothing and each cause, fitted to readings, (n,), without noise."""
    problem = replace(planned.problem, value=value)
    starts = {(NONE, 0.0): [np.zeros(problem.nuisance_count)]}
    for name, cause in planned.causes.items():
        both = [cause.at_strength(), np.zeros(len(cause.numbers))]
        starts[(name,), 0.0] = [np.r_[starts[NONE, 0.0][0], zeta] for zeta in both]
    hypotheses = Hypotheses(problem, [subset for subset, _ in starts])
    return {
        "".join(fit.subset): Rival(
            fit.zeta, problem.predicted(fit.subset, fit.zeta), problem.slopes(fit.subset, fit.zeta)
        )
        for fit in hypotheses.fits(starts)
    }


def _expected(
    planned: Analysis, rivals: Mapping[str, Rival], true: np.ndarray
) -> list[dict[str, float]]:
    """Probability of each cause, and of nothing, that is expected of readings, (n, places)."""
    problem, policy = planned.problem, planned.problem.policy
    none, one, _ = policy.prior_by_size
    prior = np.log([one / len(planned.causes) if name else none for name in rivals])
    logs = []
    for level, odds in policy.levels.items():
        total = problem.covariance + level**2 * problem.kernel
        evidence = [
            expected_evidence(rival, total, problem.covariance, true)[1]
            for rival in rivals.values()
        ]
        logs.append(np.log(odds) + prior + np.transpose(evidence))
    mass = softmax(logs, axis=(0, 2)).sum(axis=0)
    return [dict(zip(rivals, map(float, row), strict=True)) for row in mass]


def _named(mass: Mapping[str, float], policy: Policy) -> tuple[str, ...]:
    """The set of effects that a diagnosis names; none where none is sure enough."""
    causes = sorted((name for name in mass if name), key=lambda name: -mass[name])
    held = np.cumsum([mass[name] for name in causes])
    count = int(np.searchsorted(held, policy.credible * held[-1])) + 1
    return tuple(causes[:count]) if held[count - 1] >= policy.claimed else ()


def threshold(by_ordinary: np.ndarray, named: np.ndarray) -> float | None:
    """The strength from which on an effect is named; None where it lies above all.

    Args:
        by_ordinary: strengths, rising, shape (k,).
        named: whether it is named at each, shape (k,).

    Returns:
        The geometric mean of the two strengths that it lies between.
    """
    place = int(np.max(np.flatnonzero(~named) + 1, initial=0))
    if place == len(named):
        return None
    return float(np.sqrt(by_ordinary[max(place - 1, 0)] * by_ordinary[place]))


def share(listed: Sequence[EffectOutlook]) -> float:
    """Part of the effects that is named, strengths from their priors."""
    return float(np.mean([outlook.share for outlook in listed] or [0.0]))


def analyse_plan(
    measurement: Measurement, config: Config, workers: Workers, names: Sequence[str] | None
) -> Analysis:
    """The problem of a measurement that is still to be made.

    Args:
        measurement: whose readings are all 0.
        config: the model.
        workers: where simulations are computed and kept.
        names: of the causes that are tried; the whole catalogue where None.

    Raises:
        ConfigError: one line, where the base simulation does not reach all readings.
    """
    simulation = simulator_of(measurement, config, workers)
    if isinstance(simulation, FingerSimulation):
        simulation = replace(simulation, graded=True)
    if simulation.not_reached or np.isnan(readings := simulation.configured).any():
        why = "; ".join(simulation.not_reached) or "the graded mesh ends earlier"
        raise ConfigError(f"the simulation does not reach all readings: {why}")
    planned = measurement.reading(readings)
    causes = unknowns(planned, config, names)
    return analyse(simulator_of(planned, config, workers), causes, names)


ALONE: Final = (
    "these effects alone were compared: one that is named among them may still be like another "
    "of the catalogue"
)
"""Said where effects were chosen."""


def plan(
    file: Path | None,
    config: Config,
    out: Path,
    settings: DiagnosisSettings,
    changes: Change = NO_CHANGE,
    noise: Mapping[str, float] = NO_CHANGE,
) -> PlanFile:
    """Plan: tell which causes a rig could name, and which addition buys most.

    Args:
        file: TOML of the rig, see :mod:`dolfingrip.diagnosis.data.rig`; the paper's where None.
        config: the model.
        out: folder of the results; simulations are kept in it, too, unless ``settings`` tells
            another folder.
        settings: how it is made; the quick way judges those additions alone whose simulations are
            at hand.
        changes: values of the rig's protocol by key.
        noise: standard deviations by column, in place of the rig's.

    Raises:
        ConfigError: one line, for a rig that is none.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    measurement, can_vary = rig.read(file, config, changes, noise, settings.policy)
    names = settings.effects
    store = settings.store or out / "simulations"
    with staying(store, settings.workers, settings.progress) as workers:
        settings.say("simulating the rig's protocol, and with each effect")
        planned = analyse_plan(measurement, config, workers, names)
        listed = outlooks(planned)
        before, named = share(listed), {e.effect for e in listed if e.at_ordinary}
        additions: list[AdditionWorth] = []
        failed = [f"{name} could not be tried: {why}" for name, why in planned.failed.items()]
        if names is not None:
            failed.append(ALONE)
        possible = [p for p in proposals(measurement, config) if p.kind in can_vary]
        for proposal in possible:
            if settings.quick:
                failed.append(f"--quick left out: {proposal.name}")
                continue
            settings.say(f"addition: {proposal.name}")
            try:
                both = joined(measurement, read_alike(proposal, measurement))
                more = outlooks(analyse_plan(both, config, workers, names))
            except ConfigError as failure:
                failed.append(f"{proposal.name} could not be judged: {failure}")
                continue
            lifts = [e.effect for e in more if e.at_ordinary and e.effect not in named]
            after = share(more)
            additions.append(AdditionWorth(
                name=proposal.name, kind=proposal.kind, minutes=proposal.minutes, share=after,
                gain_per_minute=(after - before) / proposal.minutes, lifts=tuple(lifts),
            ))  # fmt: skip
    lasting = measurement.readings.groupby("test")["time_s"].max().sum() / 60
    return PlanFile(
        experiments=tuple(test.experiment for test in measurement.tests),
        readings=len(measurement.listed), minutes=float(lasting), share=before,
        class_share=float(np.mean([e.class_share for e in listed] or [0.0])),
        effects=tuple(listed),
        additions=tuple(sorted(additions, key=lambda a: -a.gain_per_minute)),
        warnings=(*measurement.warnings, *failed),
    )  # fmt: skip


def read_alike(proposal: Proposal, measurement: Measurement) -> Measurement:
    """The addition, read by instruments as good as the rig's: readings of 0 tell no noise."""
    noise = dict(NOISE)
    for test in measurement.tests:
        noise |= test.setup.noise
    added = proposal.measurement
    tests = [
        replace(test, setup=replace(test.setup, noise={**noise, **test.setup.noise}))
        for test in added.tests
    ]
    return replace(added, tests=tests)
