"""A diagnosis from files to a verdict: show, name, extend, measure the gain, propose what is next.

diagnosis = diagnose([Path("finger.csv")], Config(), Path("out"), DiagnosisSettings())
diagnosis.decision.answer     # "cause", "none" or "unknown"
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis, diagnosed
from dolfingrip.diagnosis.answer.gain import held_out
from dolfingrip.diagnosis.answer.settling import settled_by
from dolfingrip.diagnosis.core.unknown import check_effects
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.data.suspicion import reversed_signs, suspicions
from dolfingrip.diagnosis.downstream import compare, read_campaign
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.diagnosis.screening import analyse, simulator_of
from dolfingrip.diagnosis.simulation.aliasing import undersampled
from dolfingrip.diagnosis.simulation.runner import Workers, staying
from dolfingrip.diagnosis.simulation.unknowns import unknowns
from dolfingrip.files.diagnosis import Slip, SpecimensApart
from dolfingrip.files.diagnosis_words import slip_words
from dolfingrip.jobs.run import Progress, silent


@dataclass(frozen=True)
class DiagnosisSettings:
    """How a diagnosis is made.

    Attributes:
        workers: processes that simulate.
        store: folder of the simulations; within the results' where None.
        quick: stop after the screen.
        effects: names of those that are tried; the whole catalogue where None.
        campaign: folder of a campaign whose best designs are computed with the extended model.
        say: told what is being done.
        progress: called with each simulation that is done.
        specimens: whether those that stand apart from the others are looked for.
        policy: numbers that readings are read, simulated, compared and told by.
    """

    workers: int = 2
    store: Path | None = None
    quick: bool = False
    effects: Sequence[str] | None = None
    campaign: Path | None = None
    say: Callable[[str], None] = silent
    progress: Progress = silent
    specimens: bool = True
    policy: Policy = Policy()


def diagnose(
    files: Sequence[Path], config: Config, out: Path, settings: DiagnosisSettings
) -> Diagnosis:
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
    measurement, notes = measured.selected(measured.read(files, config, settings.policy), config)
    store = settings.store or out / "simulations"
    with staying(store, settings.workers, settings.progress) as workers:
        diagnosis = diagnose_measurement(measurement, config, workers, settings)
        diagnosis.simulated_s = sum(workers.spent_s.values())
        named = diagnosis.decision.answer == "cause"
        if settings.campaign and named and not settings.quick:
            settings.say("computing the campaign's best designs with the extended model")
            _compare_downstream(diagnosis, settings.campaign, out / "campaign", workers)
    diagnosis.warnings = [*notes, *diagnosis.warnings]
    return diagnosis


def diagnose_measurement(
    measurement: Measurement, config: Config, workers: Workers, settings: DiagnosisSettings
) -> Diagnosis:
    """Diagnose a loaded measurement on given workers.

    Args:
        measurement: the readings.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        settings: how the diagnosis is made; its folders and workers are not used.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    say, quick = settings.say, settings.quick
    doubts: list[Slip] = []

    def suspect(raised: Sequence[Slip]) -> None:
        for doubt in raised:
            if doubt not in doubts:
                say(f"check the data first: {slip_words(doubt)}")
                doubts.append(doubt)

    causes = unknowns(measurement, config, settings.effects)
    suspect(reversed_signs(measurement, config))
    simulation = simulator_of(measurement, config, workers, say)
    suspect(suspicions(simulation.measurement, simulation.configured))
    analysis = analyse(simulation, causes, settings.effects, say, quick=quick)
    diagnosis = diagnosed(analysis, config, doubts, quick=quick, say=say)
    outside = diagnosis.analysis.specimens_apart() if settings.specimens else None
    if outside is not None:
        names, log_odds = outside
        say(f"diagnosing without {' and '.join(names)}, apart from the other specimens")
        others = {test.number for test in measurement.tests if test.specimen not in names}
        alone = replace(settings, quick=True, specimens=False)
        second = diagnose_measurement(measurement.of(others), config, workers, alone)
        odds = float(np.exp(min(log_odds, 100.0)))
        diagnosis.apart = SpecimensApart(specimens=names, odds=odds, without=second.verdict)
    diagnosis.warnings = [*measurement.warnings, *undersampled(measurement, config, workers)]
    thorough = not quick and diagnosis.decision.answer == "cause"
    if thorough:
        say("measuring the gain on readings that are left out")
        diagnosis.gain, diagnosis.gain_claimed = held_out(diagnosis.analysis, diagnosis.posterior)
    say("looking for what would settle it")
    diagnosis.next, failed = settled_by(diagnosis, say, simulating=not quick)
    diagnosis.warnings += failed
    return diagnosis


def _compare_downstream(diagnosis: Diagnosis, folder: Path, out: Path, workers: Workers) -> None:
    try:
        with workers.pool() as pool:
            extended = diagnosis.extended(diagnosis.decision.best)
            diagnosis.downstream = compare(
                folder, diagnosis.config, extended, out, pool, diagnosis.policy
            )
    except ConfigError as error:
        diagnosis.warnings.append(f"--campaign {folder}: {error}")
