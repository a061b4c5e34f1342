"""A diagnosis from files to a verdict: show, name, extend, measure the gain, propose what is next.

diagnosis = diagnose([Path("finger.csv")], Config(), Path("out"), Settings())
diagnosis.outcome.verdict.answer     # "cause", "none" or "unknown"
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign.campaign import Standing
from dolfingrip.diagnosis import conclude as conclusions
from dolfingrip.diagnosis import contact_shift, extend, selection
from dolfingrip.diagnosis.additions import worth
from dolfingrip.diagnosis.additions.protocols import proposals
from dolfingrip.diagnosis.conclude import NONE, Conclusion
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.data.noise import noise as instrument_noise
from dolfingrip.diagnosis.data.suspicion import suspicions
from dolfingrip.diagnosis.downstream import Downstream, compare, read_campaign
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.gain.gain import GainRow, claimed, gains
from dolfingrip.diagnosis.gain.rivals import NuisanceFit
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.laplace import Estimate
from dolfingrip.diagnosis.inference.posterior import Posterior
from dolfingrip.diagnosis.inference.verdict import Verdict
from dolfingrip.diagnosis.model import area_spread, coupons_alone, modulus_parameter
from dolfingrip.diagnosis.noise_check import NoiseDoubts, noise_doubts
from dolfingrip.diagnosis.noise_model import NoiseModel, noise_model
from dolfingrip.diagnosis.problem import Problem, index_of
from dolfingrip.diagnosis.search import search
from dolfingrip.diagnosis.simulation.base import BaseSimulation, simulate_base
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.tried import check_effects, tried
from dolfingrip.diagnosis.workers import staying

MESH_UNKNOWN: Final = (
    "what the mesh gets wrong is taken as nothing, as only a graded mesh of hexahedra tells it: it "
    "may be named as an effect; compare readings with a finer mesh (mesh.refine=2, mesh.size_mm)"
)
"""Said where there is no second mesh to compare with."""

RIVAL: Final = 0.05
"""Probability by the leading effect's from which on an effect is worth being told apart."""


@dataclass(frozen=True)
class Settings:
    """How a diagnosis is made.

    Attributes:
        workers: processes that simulate.
        store: folder of the simulations; within the results' where None.
        quick: stop after the screen.
        effects: names of those that are tried; the whole catalogue where None.
        campaign: folder of a campaign whose best designs are computed with the extended model.
        say: told what is being done.
        progress: called with each simulation that is done.
    """

    workers: int = 2
    store: Path | None = None
    quick: bool = False
    effects: Sequence[str] | None = None
    campaign: Path | None = None
    say: Callable[[str], None] = lambda text: None
    progress: Callable[[Standing], None] = lambda standing: None


@dataclass
class Diagnosis:
    """Everything that was found, for tables, plots and texts.

    Attributes:
        problem: arrays of the readings.
        noise: what was taken.
        fits: of hypotheses.
        conclusion: under the most probable model of the noise.
        verdict: averaged over these models.
        under: the verdict under each alone.
        models: probability of each.
        posterior: probabilities of all hypotheses, averaged over these models.
        doubts: what speaks against the noise as believed.
        gain: errors on what was left out.
        next: additions, the best first.
        downstream: what the extended model changes about a campaign's best designs.
        suspicions: slips of units, signs and columns, a question each.
        warnings: what else to beware of, a sentence each.
        quick: whether it stopped after the screen.
        simulated_s: time of all simulations on a worker each, those from the store included.
    """

    problem: Problem
    noise: NoiseModel
    fits: Mapping[frozenset[str], Hypothesis]
    conclusion: Conclusion
    verdict: Verdict
    under: Mapping[str, Verdict]
    models: Mapping[str, float]
    posterior: Posterior
    doubts: NoiseDoubts
    gain: list[GainRow] = field(default_factory=list)
    next: list[worth.AdditionWorth] = field(default_factory=list)
    downstream: Downstream | None = None
    suspicions: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    quick: bool = False
    simulated_s: float = 0.0

    @property
    def none(self) -> Hypothesis:
        """The base model, its modulus fitted."""
        return self.fits[NONE]

    @property
    def best(self) -> Hypothesis:
        """The fit that the verdict is about; the base model's where it names no cause."""
        if self.verdict.answer != "cause":
            return self.none
        leaders = [found.names[0] for found in self.verdict.named]
        for key in (frozenset(leaders), frozenset(leaders[:1])):
            if key in self.fits:
                return self.fits[key]
        return self.none

    def numbers(self, fit: Hypothesis) -> list[tuple[str, Estimate]]:
        """Fitted numbers by key of the configuration, with 90 % intervals."""
        measurement = self.problem.measurement
        area = area_spread(measurement) if coupons_alone(measurement) else 0.0
        config = self.problem.base.config
        return extend.parameters(config, fit, fit.estimates(self.problem), area)

    @cached_property
    def nuisances_fitted(self) -> Vector:
        """The base model with its nuisances fitted as well as they can be, shape (n,)."""
        everything = np.ones(len(self.problem.value), dtype=bool)
        return NuisanceFit(self.problem, self.none).refitted(everything)

    @property
    def takes_part(self) -> float:
        """Probability that one of the leading class takes part, beside whatever else."""
        names = [score.name for score in self.conclusion.scores]
        own = [names.index(name) for each in self.verdict.named[:1] for name in each.names]
        found = self.posterior
        return found.with_either(own) + float(found.beside[own].sum()) if own else 0.0

    @property
    def gain_claimed(self) -> bool | None:
        """Whether the cause beats both rivals; None where nothing was compared."""
        return claimed(self.gain) if self.gain else None


def diagnose(files: Sequence[Path], config: Config, out: Path, settings: Settings) -> Diagnosis:
    """Find out what the simulation gets wrong about measured data, and why.

    Args:
        files: measured CSVs, each with its TOML.
        config: the model that is diagnosed.
        out: folder of the results; simulations are kept in it, too, unless ``settings`` tells
            another folder.
        settings: how it is made.

    Raises:
        ConfigError: one line, for bad data.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    check_effects(settings.effects)
    if settings.campaign:
        read_campaign(settings.campaign)
    measurement, notes = selection.selected(measured.read(files, config), config)
    store = settings.store or out / "simulations"
    with staying(store, settings.workers, settings.progress) as workers:
        found = diagnose_measurement(measurement, config, workers, settings)
        found.simulated_s = sum(workers.spent_s.values())
        if settings.campaign and found.best.effects and not settings.quick:
            settings.say("computing the campaign's best designs with the extended model")
            _compare_downstream(found, settings.campaign, config, out / "campaign", workers)
    found.warnings = [*notes, *found.warnings]
    return found


def _compare_downstream(
    found: Diagnosis, folder: Path, config: Config, out: Path, workers: Workers
) -> None:
    try:
        found.downstream = compare(folder, config, found.best, out, workers.where)
    except ConfigError as error:
        found.warnings.append(f"--campaign {folder}: {error}")


def diagnose_measurement(
    measurement: Measurement, config: Config, workers: Workers, settings: Settings
) -> Diagnosis:
    """The same for readings that are there, with workers of the caller's."""
    settings.say("simulating the measurement as configured, and with each effect")
    base = simulate_base(measurement, config, workers, effects=tried(settings.effects))
    found = _name(measurement, base, workers, settings)
    doubts = [each.sentence() for each in suspicions(measurement, base.readings)]
    found.suspicions = doubts
    found.warnings = [*measurement.warnings, *_failures(base), *found.warnings]
    if settings.quick or found.verdict.answer != "cause":
        return found
    if found.best.effects:
        settings.say("measuring the gain on readings that are left out")
        found.gain = gains(found.problem, found.none, found.best)
        if not found.gain_claimed:
            found.warnings.append(
                "the cause does not predict readings that were left out better than refitted "
                "nuisances or a process without cause: take it as a suspicion"
            )
    _propose(found, config, workers, settings)
    return found


def _failures(base: BaseSimulation) -> list[str]:
    found = [f"base simulation: {each.sentence}" for each in base.failures]
    if not base.mesh.size and any(t.experiment != "coupon" for t in base.measurement.tests):
        found.append(MESH_UNKNOWN)
    for candidate in base.candidates:
        if candidate.failures and not len(candidate.shapes):
            why = candidate.failures[0].sentence
            found.append(f"{candidate.name} could not be tried: {why}")
    return found


def _problem(measurement: Measurement, base: BaseSimulation) -> tuple[Problem, NoiseModel]:
    kept = np.flatnonzero(np.isfinite(base.readings) & np.isfinite(base.by_led))
    if len(kept) < 2:
        why = "; ".join(dict.fromkeys(each.sentence for each in base.failures))
        raise ConfigError(f"the base simulation reaches no reading: {why}")
    index = index_of(measurement).iloc[kept].reset_index(drop=True)
    value = measurement.listed()["value"].to_numpy(dtype=float)[kept]
    noise = noise_model(measurement, index, value, base.readings[kept], kept)
    led_std = instrument_noise(measurement).led[kept]
    scale = modulus_parameter(measurement, base.config)
    return Problem(measurement, base, kept, index, value, noise.noise, led_std, scale), noise


def _name(
    measurement: Measurement, base: BaseSimulation, workers: Workers, settings: Settings
) -> Diagnosis:
    """Fits and verdict."""
    problem, noise = _problem(measurement, base)
    fitter = Fitter(problem, workers, settings.say)
    none = fitter.none()
    settings.say("comparing effects")
    analysis = conclusions.screen(problem, none)
    first = conclusions.conclude(problem, analysis, {NONE: none})
    if not settings.quick and contact_shift.needed(problem, first, none):
        settings.say("fitting the gap and the regulator's zero, which move the contact")
        problem = fitter.problem = contact_shift.with_shifts(problem)
        none = fitter.none()
        analysis = conclusions.screen(problem, none)
    fits = {NONE: none} if settings.quick else search(fitter, analysis, none)
    found: dict[str, Conclusion] = {}
    for name, model in noise.others.items():
        believed = model is noise.noise or name == next(iter(noise.others))
        own = problem if believed else problem.with_noise(model)
        under = analysis if believed else conclusions.screen(own, none)
        found[name] = conclusions.conclude(own, under, fits)
    posterior, models = conclusions.averaged(found, noise.prior)
    best = max(models, key=lambda name: models[name])
    thresholds = found[best].analysis.thresholds
    verdict = found[best].verdict(thresholds, posterior)
    under_each = {name: each.verdict(thresholds) for name, each in found.items()}
    settings.say("checking the noise")
    doubts = noise_doubts(found[best], fits, noise)
    warnings = [
        *fitter.failures,
        *_verdict_notes(verdict),
        *_noise_notes(verdict, under_each, models),
    ]
    return Diagnosis(
        found[best].problem, noise, fits, found[best], verdict, under_each, models, posterior,
        doubts, warnings=warnings, quick=settings.quick,
    )  # fmt: skip


def _verdict_notes(verdict: Verdict) -> list[str]:
    """The verdict's notes, those of all effects that cannot be seen in one."""
    hidden = [score.name for score in verdict.scores if not score.visible]
    notes = [n for n in verdict.notes if not n.endswith("cannot be seen in these readings")]
    return [*notes, *([f"not to be seen in these readings: {', '.join(hidden)}"] if hidden else [])]


def _noise_notes(
    verdict: Verdict, under: Mapping[str, Verdict], models: Mapping[str, float]
) -> list[str]:
    """How the verdict depends on the noise."""
    return [
        f"with noise {name} (probability {models[name]:.2f}): {each.sentence()}"
        for name, each in under.items()
        if (each.answer, set(each.names)) != (verdict.answer, set(verdict.names))
    ]


def _propose(found: Diagnosis, config: Config, workers: Workers, settings: Settings) -> None:
    """Rank further experiments where effects are tied."""
    scores = {score.name: score for score in found.conclusion.scores}
    leading = found.verdict.named[0]
    names = [score.name for score in found.conclusion.scores]
    alone = found.posterior.singles
    best = max(alone.max(), 1e-300)
    tied = [
        (found.fits[frozenset([name])], max(float(alone[names.index(name)]), 1e-6))
        for name in scores
        if frozenset([name]) in found.fits
        and (name in leading.names or alone[names.index(name)] >= RIVAL * best)
    ]
    if len(tied) < 2:
        return
    found.next, failed = worth.judge(
        found.problem, tied, proposals(found.problem.measurement, config), workers, settings.say
    )
    found.warnings += failed
