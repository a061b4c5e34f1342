"""A diagnosis from files to a verdict: show, name, extend, measure the gain, propose what is next.

diagnosis = diagnose([Path("finger.csv")], Config(), Path("out"), Settings())
diagnosis.decision.answer     # "cause", "none" or "unknown"
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis import selection
from dolfingrip.diagnosis.answer.found import Diagnosis
from dolfingrip.diagnosis.coupon.diagnose import diagnose_coupons
from dolfingrip.diagnosis.coupon.simulation import in_closed_form
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.downstream import compare, read_campaign
from dolfingrip.diagnosis.finger.diagnose import diagnose_fingers
from dolfingrip.diagnosis.simulation.runner import Workers, staying
from dolfingrip.diagnosis.tried import check_effects
from dolfingrip.jobs.run import Progress, silent


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
) -> Diagnosis:
    """The same for readings that are there, with workers of the caller's."""
    if in_closed_form(measurement, config):
        return diagnose_coupons(
            measurement, config, settings.effects, quick=settings.quick, say=settings.say
        )
    return diagnose_fingers(
        measurement, config, workers, settings.effects, quick=settings.quick, say=settings.say
    )


def _compare_downstream(found: Diagnosis, folder: Path, out: Path, workers: Workers) -> None:
    try:
        with workers.pool() as pool:
            found.downstream = compare(folder, found.config, found.extended, out, pool)
    except ConfigError as error:
        found.warnings.append(f"--campaign {folder}: {error}")
