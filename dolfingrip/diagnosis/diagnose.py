"""A diagnosis from files to a verdict: show, name, extend, measure the gain, propose what is next.

diagnosis = diagnose([Path("finger.csv")], Config(), Path("out"), Settings())
diagnosis.outcome.verdict.answer     # "cause", "none" or "unknown"
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis import cautions, contact_shift, selection
from dolfingrip.diagnosis import conclude as conclusions
from dolfingrip.diagnosis.additions import worth
from dolfingrip.diagnosis.additions.protocols import proposals
from dolfingrip.diagnosis.between import between
from dolfingrip.diagnosis.conclude import NONE, Conclusion
from dolfingrip.diagnosis.coupon.diagnose import diagnose_coupons
from dolfingrip.diagnosis.coupon.found import CouponDiagnosis
from dolfingrip.diagnosis.coupon.simulation import in_closed_form
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.data.noise import noise as instrument_noise
from dolfingrip.diagnosis.data.suspicion import suspicions
from dolfingrip.diagnosis.downstream import compare, read_campaign
from dolfingrip.diagnosis.finger.diagnose import diagnose_fingers
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.found import Diagnosis
from dolfingrip.diagnosis.gain.gain import gains
from dolfingrip.diagnosis.model import modulus_parameter
from dolfingrip.diagnosis.noise_check import noise_doubts
from dolfingrip.diagnosis.noise_model import NoiseModel, noise_model
from dolfingrip.diagnosis.problem import Problem, index_of
from dolfingrip.diagnosis.search import search
from dolfingrip.diagnosis.simulation.base import BaseSimulation, simulate_base
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.walls import WallCurves, simulate_walls
from dolfingrip.diagnosis.tried import check_effects, tried
from dolfingrip.diagnosis.workers import staying
from dolfingrip.jobs.run import Progress, silent

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
        anew: compute the simulations that come with the package, too.
        say: told what is being done.
        progress: called with each simulation that is done.
    """

    workers: int = 2
    store: Path | None = None
    quick: bool = False
    effects: Sequence[str] | None = None
    campaign: Path | None = None
    anew: bool = False
    say: Callable[[str], None] = lambda text: None
    progress: Progress = silent


def diagnose(
    files: Sequence[Path], config: Config, out: Path, settings: Settings
) -> CouponDiagnosis:
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
    with staying(store, settings.workers, settings.progress, anew=settings.anew) as workers:
        found = judged(measurement, config, workers, settings)
        found.simulated_s = sum(workers.spent_s.values())
        named = found.decision.answer == "cause"
        if settings.campaign and named and not settings.quick:
            settings.say("computing the campaign's best designs with the extended model")
            _compare_downstream(found, settings.campaign, out / "campaign", workers)
    found.warnings = [*notes, *found.warnings]
    return found


def judged(
    measurement: Measurement, config: Config, workers: Workers, settings: Settings
) -> CouponDiagnosis:
    """The same for readings that are there, with workers of the caller's."""
    if in_closed_form(measurement, config):
        return diagnose_coupons(
            measurement, config, settings.effects, quick=settings.quick, say=settings.say
        )
    return diagnose_fingers(
        measurement, config, workers, settings.effects, quick=settings.quick, say=settings.say
    )


def _compare_downstream(found: CouponDiagnosis, folder: Path, out: Path, workers: Workers) -> None:
    try:
        with workers.pool() as pool:
            found.downstream = compare(folder, found.config, found.extended, out, pool)
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
    found.not_reached = cautions.not_reached(measurement, base)
    found.warnings = [*measurement.warnings, *cautions.of_simulation(base), *found.warnings]
    if settings.quick or found.verdict.answer != "cause":
        return found
    if found.best.effects:
        settings.say("measuring the gain on readings that are left out")
        found.gain, found.odds = gains(found.problem, found.none, found.best)
        if not found.gain_claimed:
            found.warnings.append(
                "the cause does not predict readings that were left out better than refitted "
                "nuisances or a process without cause: take it as a suspicion"
            )
    _propose(found, config, workers, settings)
    return found


def problem_of(
    measurement: Measurement, base: BaseSimulation, walls: WallCurves | None = None
) -> tuple[Problem, NoiseModel]:
    """The readings that the base simulation reached, and the noise that is taken for them.

    Args:
        measurement: whose readings they are.
        base: of it.
        walls: readings with other walls, where these are no linear nuisance.

    Raises:
        ConfigError: one line, where it reached less than two.
    """
    kept = np.flatnonzero(np.isfinite(base.readings) & np.isfinite(base.by_control))
    listed = measurement.listed()
    reached = set(listed["test"].to_numpy()[kept])
    for test in measurement.tests:
        if test.number not in reached:
            why = "; ".join(each.sentence for each in base.failures if test in each.tests)
            raise ConfigError(
                f"{test.experiment} of {test.specimen}: the base simulation reaches no reading: "
                f"{why}"
            )
    index = index_of(measurement).iloc[kept].reset_index(drop=True)
    value = listed["value"].to_numpy(dtype=float)[kept]
    noise = noise_model(measurement, index, value, base.readings[kept], kept)
    control_std = instrument_noise(measurement).control[kept]
    scale = modulus_parameter(measurement, base.config)
    problem = Problem(measurement, base, kept, index, value, noise.noise, control_std, scale, walls)
    return problem, noise


def _name(
    measurement: Measurement, base: BaseSimulation, workers: Workers, settings: Settings
) -> Diagnosis:
    """Fits and verdict."""
    problem, noise = problem_of(measurement, base, simulate_walls(measurement, base, workers))
    fitter = Fitter(problem, workers, settings.say)
    none = fitter.settled()
    problem = fitter.problem
    settings.say("comparing effects")
    analysis = conclusions.screen(problem, none)
    first = conclusions.conclude(problem, analysis, {NONE: none})
    if not settings.quick and contact_shift.needed(problem, first, none):
        settings.say("fitting the gap and the regulator's zero, which move the contact")
        problem = fitter.problem = contact_shift.with_shifts(problem)
        none = fitter.none()
        analysis = conclusions.screen(problem, none)
    quick = settings.quick
    fits = {NONE: none} if quick else search(fitter, analysis, none)
    judged = between(fitter, analysis, none) if quick else fits
    found: dict[str, Conclusion] = {}
    for name, model in noise.others.items():
        believed = model is noise.noise or name == next(iter(noise.others))
        own = problem if believed else problem.with_noise(model)
        under = analysis if believed else conclusions.screen(own, none)
        found[name] = conclusions.conclude(own, under, judged)
    posterior, models = conclusions.averaged(found, noise.prior)
    best = max(models, key=lambda name: models[name])
    thresholds = found[best].analysis.thresholds
    verdict = found[best].verdict(thresholds, posterior)
    under_each = {name: each.verdict(thresholds) for name, each in found.items()}
    settings.say("checking the noise")
    doubts = noise_doubts(found[best], judged, noise, models)
    warnings = [
        *fitter.failures,
        *cautions.of_verdict(verdict),
        *cautions.of_noise(verdict, under_each, models),
    ]
    return Diagnosis(
        found[best].problem, noise, fits, found[best], verdict, under_each, models, posterior,
        doubts, warnings=warnings, quick=quick,
    )  # fmt: skip


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
