"""A plan: what a rig could name, and which addition buys most per minute.

Each effect is hidden in turn, at strengths from its prior. The readings that it makes, with noise,
the rig's own errors and a discrepancy as probable as a diagnosis takes it to be, are searched and
decided as measured ones are, one cause at a time. The share of draws in which the answer is this
effect alone is the probability that it is named.
"""

from __future__ import annotations

import zlib
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.special import ndtri

from dolfingrip.config import NO_CHANGE, Change, Config, ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.answer.refining import doubtful
from dolfingrip.diagnosis.core.decision import decide, held
from dolfingrip.diagnosis.core.evidence import Key, Visibility
from dolfingrip.diagnosis.core.search import one_at_a_time
from dolfingrip.diagnosis.core.unknown import Cause
from dolfingrip.diagnosis.coupon import CouponSimulation, in_closed_form
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.measurement import Measurement, joined
from dolfingrip.diagnosis.diagnose import DiagnosisSettings
from dolfingrip.diagnosis.finger import FingerSimulation, coarser
from dolfingrip.diagnosis.screening import analyse, simulator_of
from dolfingrip.diagnosis.simulation.runner import Workers, staying
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.experiments.synthetic import NOISE
from dolfingrip.files.plan import AdditionWorth, EffectOutlook, PlanFile

NOISES: Final = 2
"""Draws of everything else at each strength."""


Draw = tuple[tuple[str, ...], dict[str, float]]
"""Of readings with a hidden cause: the set that a diagnosis names in which this one is, empty where
it names no such set; and the probability of each effect that it finds."""


@dataclass(frozen=True, eq=False)
class Hidden:
    """A cause that is hidden in readings, at strengths from its prior, and looked for.

    Attributes:
        planned: the readings to be.
        cause: the effect.
    """

    planned: Analysis[Any]
    cause: Cause
    _before: dict[Key, np.ndarray] = field(default_factory=dict)
    _drawn: dict[int, list[Draw]] = field(default_factory=dict)

    @cached_property
    def visibility(self) -> Visibility:
        """Strengths of causes."""
        problem = self.planned.problem
        return Visibility(problem, np.zeros(problem.nuisance_count))

    def strength(self, by_ordinary: float) -> float:
        """Length of its change at a strength, standard deviations."""
        return self.visibility.strength(self.cause.name, self.at(by_ordinary))

    def diagnosed(self, zeta: np.ndarray, rng: np.random.Generator) -> Draw:
        """The cause at ζ under noise, nuisances and a discrepancy as probable as it may be.

        More readings with the same ``rng`` have the same noise, as far as both go.
        """
        problem, name = self.planned.problem, self.cause.name
        if self.visibility.strength(name, zeta) < 0.5 * problem.policy.unlikely:
            return (), {}
        odds = problem.policy.levels
        level = problem.levels[float(rng.choice([*odds], p=[*odds.values()]))]
        noise = level.coloured(rng.standard_normal(len(problem.value)))
        value = problem.base + self.visibility.change(name, zeta) + noise
        posterior = one_at_a_time(
            {k: model.read(value) for k, model in problem.levels.items()}, self._before
        )
        decision = decide(posterior)
        named = decision.first if decision.answer == "cause" and name in decision.first else ()
        subsets = posterior.subsets
        return named, {other: held(subsets, (other,)) for other in self.planned.causes}

    @cached_property
    def strengths(self) -> np.ndarray:
        """Strengths that are hidden, by the ordinary one, rising, shape (strengths,)."""
        first = next(number for number in self.cause.numbers if number.amplitude)
        count = self.planned.problem.policy.strengths
        middles = ndtri((np.arange(count) + 0.5) / count)
        values = first.at(middles)
        start, step = self.cause.start_and_step(first)
        return np.asarray(np.sort(np.abs(values - start) / abs(step)))

    @property
    def label(self) -> str:
        """Numbers of the cause at the ordinary strength, for people."""
        at = zip(self.cause.numbers, self.at(1.0), strict=True)
        return ", ".join(f"{n.key.rpartition('.')[2]} = {float(n.at(z)):.4g}" for n, z in at)

    def at(self, strength: float, rng: np.random.Generator | None = None) -> np.ndarray:
        """ζ of its numbers at a strength; those of its shape from their priors, or their middles.

        Args:
            strength: by the ordinary one.
            rng: draws the shape; None for the middles.
        """
        return self.cause.at_strength(self.cause.box(), strength, rng)

    def drawn(self, place: int) -> list[Draw]:
        """The draws at one of the strengths."""
        if place not in self._drawn:
            name, strength = self.cause.name, float(self.strengths[place])
            draws = []
            for turn in range(NOISES):
                rng = np.random.default_rng([zlib.crc32(name.encode()), place, turn])
                draws.append(self.diagnosed(self.at(strength, rng), rng))
            self._drawn[place] = draws
        return self._drawn[place]

    def counted(self, counts: Callable[[Draw], bool], full: int | None = None) -> np.ndarray:
        """How many draws are judged so at each strength, shape (strengths,).

        Not all are drawn: where none is, none is at a lower strength; where all are, all are at a
        higher one.

        Args:
            counts: of a draw.
            full: place from which on all are known to be; None: of none it is known.
        """
        count = np.full(len(self.strengths), NOISES)

        def look(low: int, high: int, place: int) -> None:
            if low >= high:
                return
            count[place] = sum(counts(draw) for draw in self.drawn(place))
            if count[place]:
                look(low, place, (low + place) // 2)
            else:
                count[low:place] = 0
            if count[place] < NOISES:
                look(place + 1, high, (place + 1 + high) // 2)
            else:
                count[place + 1 : high] = NOISES

        end = len(self.strengths) if full is None else full
        look(0, end, end - 1)
        return count


def namings(planned: Analysis[Any], before: Sequence[EffectOutlook] = ()) -> list[EffectOutlook]:
    """Find for each effect from which strength on it is named, the strongest first.

    Args:
        planned: the readings to be.
        before: of fewer readings: what these name more readings name, too.
    """
    earlier = {outlook.effect: outlook for outlook in before}
    outlooks = [
        _naming(Hidden(planned, cause), earlier.get(name)) for name, cause in planned.causes.items()
    ]
    outlooks += [EffectOutlook(effect=name) for name in planned.unseen]
    return sorted(outlooks, key=lambda outlook: -outlook.strength_sigma)


def share(outlooks: Sequence[EffectOutlook]) -> float:
    """Part of the effects that is named, strengths from their priors."""
    return float(np.mean([outlook.share for outlook in outlooks] or [0.0]))


def _naming(hidden: Hidden, before: EffectOutlook | None) -> EffectOutlook:
    full = before.sure if before else None
    alone = hidden.counted(lambda draw: len(draw[0]) == 1, full)
    # of an addition it is told what it names, not what it nearly does
    within = alone if before else hidden.counted(lambda draw: len(draw[0]) > 0)
    named = threshold(hidden.strengths, alone)
    return EffectOutlook(
        effect=hidden.cause.name, ordinary=hidden.label,
        strength_sigma=hidden.strength(1.0), named_from=named,
        named_from_sigma=None if named is None else hidden.strength(named),
        class_from=threshold(hidden.strengths, within), share=float(alone.mean()) / NOISES,
        class_share=float(within.mean()) / NOISES, confused_with=() if before else _alike(hidden),
        sure=int(np.max(np.flatnonzero(alone < NOISES) + 1, initial=0)),
    )  # fmt: skip


def threshold(strengths: np.ndarray, count: np.ndarray) -> float | None:
    """The strength that leaves the fewest draws named below and not named above it.

    Args:
        strengths: rising, shape (k,).
        count: draws that are named at each, of :data:`NOISES`, shape (k,).

    Returns:
        The geometric mean of the two strengths that it lies between; None where it lies above all.
    """
    missed = NOISES - count
    wrong = np.r_[0, np.cumsum(count)] + np.r_[np.cumsum(missed[::-1])[::-1], 0]
    # the highest of equals: what is told is not too little
    place = len(wrong) - 1 - int(np.argmin(wrong[::-1]))
    if place == len(strengths):
        return None
    return float(np.sqrt(strengths[max(place - 1, 0)] * strengths[place]))


def _alike(hidden: Hidden) -> tuple[str, ...]:
    """Effects nearly as probable as it, in the draws about the ordinary strength."""
    name = hidden.cause.name
    mass: dict[str, float] = defaultdict(float)
    away = np.abs(np.log(np.maximum(hidden.strengths, 1e-9)))
    for place in np.argsort(away, kind="stable")[:2]:
        for _, probability in hidden.drawn(int(place)):
            for other, p in probability.items():
                mass[other] += p
    least = hidden.planned.problem.policy.matters * mass[name]
    others = sorted(mass, key=lambda n: -mass[n])
    return tuple(n for n in others if n != name and mass[n] > least)


def analyse_plan(
    measurement: Measurement, config: Config, workers: Workers, names: Sequence[str] | None
) -> Analysis[Any]:
    """The problem of a measurement that is still to be made.

    Args:
        measurement: whose readings are all 0.
        config: the model.
        workers: where simulations are computed and kept.
        names: of the causes that are tried; the whole catalogue where None.

    Raises:
        ConfigError: one line, where the base simulation does not reach all readings.
    """
    if in_closed_form(measurement, config):
        readings = CouponSimulation(measurement, config).configured
    else:
        simulation = FingerSimulation(measurement, config, workers, coarser(config)[0])
        if np.isnan(readings := simulation.configured).any():
            failures = (*simulation.first.failures, *simulation.fine.failures)
            why = "; ".join(dict.fromkeys(failure.why for failure in failures))
            raise ConfigError(f"the simulation does not reach all readings: {why}")
    planned = measurement.reading(readings)
    causes = unknowns(planned, config, names)
    analysis = analyse(simulator_of(planned, config, workers), causes, names)
    for name in [*analysis.causes] if analysis.closed_form else ():
        analysis = _with_rivals(analysis, name)
    return analysis


def _with_rivals(planned: Analysis[Any], name: str) -> Analysis[Any]:
    """Simulate what follows a cause of ordinary strength where it follows it best."""
    for _ in range(planned.measurement.policy.tries // 2):
        hidden = Hidden(planned, planned.causes[name])
        value = planned.problem.base + hidden.visibility.change(name, hidden.at(1.0))
        levels = {k: model.read(value) for k, model in planned.problem.levels.items()}
        posterior = one_at_a_time(levels, {})
        measured = replace(planned, problem=replace(planned.problem, value=value))
        _, fits = doubtful(measured, posterior, Counter())
        pairs = zip(fits, planned.simulated(fits), strict=True)
        runs = [(fit.subset[:1], run) for fit, run in pairs if run is not None]
        runs = [(causes, run) for causes, run in runs if causes and causes[0] in planned.causes]
        if not runs:
            break
        planned = replace(planned, problem=planned.problem.beside(runs))
    return planned


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
        outlooks = namings(planned)
        before, named = share(outlooks), {e.effect for e in outlooks if e.at_ordinary}
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
                more = namings(analyse_plan(both, config, workers, names), outlooks)
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
        class_share=float(np.mean([e.class_share for e in outlooks] or [0.0])),
        effects=tuple(outlooks),
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
