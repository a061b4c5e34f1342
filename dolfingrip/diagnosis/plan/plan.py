"""A plan: what a rig could name, and which addition buys most per minute."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.plan.case import joined, planned_case
from dolfingrip.diagnosis.plan.naming import namings, share, share_of_classes
from dolfingrip.diagnosis.simulation.runner import NotAtHand, staying
from dolfingrip.experiments.synthetic import NOISE
from dolfingrip.files.plan import AdditionWorth, EffectOutlook, PlanFile
from dolfingrip.jobs.run import Progress, silent

ALONE: Final = (
    "these effects alone were compared: one that is named among them may still be like another "
    "of the catalogue"
)
"""Said where effects were chosen."""


@dataclass(frozen=True)
class Settings:
    """How a plan is made.

    Attributes:
        workers: processes that simulate.
        store: folder of the simulations.
        quick: judge those additions alone whose simulations are at hand.
        effects: names of those that may be there; the whole catalogue where None.
        say: told what is being done.
        progress: called with each simulation that is done.
    """

    store: Path
    workers: int = 2
    quick: bool = False
    effects: Sequence[str] | None = None
    say: Callable[[str], None] = lambda text: None
    progress: Progress = silent


def plan(
    file: Path | None,
    config: Config,
    settings: Settings,
    changes: Mapping[str, Any] = MappingProxyType({}),
    noise: Mapping[str, float] | None = None,
) -> PlanFile:
    """What a rig could find out.

    Args:
        file: TOML of the rig, see :mod:`dolfingrip.diagnosis.data.rig`; the paper's where None.
        config: the model.
        settings: how it is made.
        changes: values of the rig's protocol by key.
        noise: standard deviations by column, in place of the rig's.

    Raises:
        ConfigError: one line, for a rig that is none.
        SchedulerGone: the workers are gone; what was computed is kept.
    """
    measurement, can_vary = rig.read(file, config, changes, noise)
    names = settings.effects
    with staying(settings.store, settings.workers, settings.progress) as workers:
        settings.say("simulating the rig's protocol, and with each effect")
        own = planned_case(measurement, config, workers, names)
        found = namings(own)
        before = share(found)
        additions: list[AdditionWorth] = []
        failed = [f"{name} could not be tried: {why}" for name, why in own.failed.items()]
        if names is not None:
            failed.append(ALONE)
        possible = [each for each in proposals(measurement, config) if each.kind in can_vary]
        for proposal in possible:
            settings.say(f"addition: {proposal.name}")
            hands = workers.at_hand() if settings.quick else workers
            try:
                whole = joined(measurement, read_alike(proposal, measurement))
                more = namings(planned_case(whole, config, hands, names), found)
            except (NotAtHand, ConfigError) as failure:
                failed.append(f"{proposal.name} could not be judged: {failure}")
                continue
            additions.append(_judged(proposal, found, before, more))
    lasting = measurement.readings.groupby("test")["time_s"].max().sum() / 60
    return PlanFile(
        experiments=tuple(test.experiment for test in measurement.tests),
        readings=len(measurement.listed()), minutes=float(lasting), share=before,
        class_share=share_of_classes(found), effects=tuple(found),
        additions=tuple(sorted(additions, key=lambda a: -a.gain_per_minute)),
        warnings=(*measurement.warnings, *failed),
    )  # fmt: skip


def read_alike(proposal: Proposal, measurement: Measurement) -> Measurement:
    """The addition, read by instruments as good as the rig's: readings of 0 tell no noise."""
    noise = dict(NOISE)
    for test in measurement.tests:
        noise |= test.setup.noise
    own = proposal.measurement
    tests = [
        replace(test, setup=replace(test.setup, noise={**noise, **test.setup.noise}))
        for test in own.tests
    ]
    return replace(own, tests=tests)


def _judged(
    proposal: Proposal,
    before: Sequence[EffectOutlook],
    share_before: float,
    after: Sequence[EffectOutlook],
) -> AdditionWorth:
    named = {each.effect for each in before if each.at_ordinary}
    lifts = [each.effect for each in after if each.at_ordinary and each.effect not in named]
    whole = share(after)
    return AdditionWorth(
        name=proposal.name, kind=proposal.kind, minutes=proposal.minutes, share=whole,
        gain_per_minute=(whole - share_before) / proposal.minutes, lifts=tuple(lifts),
    )  # fmt: skip
