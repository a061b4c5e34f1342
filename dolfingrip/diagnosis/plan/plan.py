"""A plan: what a rig could name, and which addition buys most per minute."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import pandas as pd

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal, proposals
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.coupon.analysis import analyse_coupons
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation, in_closed_form
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.analysis import analyse_fingers
from dolfingrip.diagnosis.plan.naming import namings, share, share_of_classes
from dolfingrip.diagnosis.simulation.nuisances import base_variant
from dolfingrip.diagnosis.simulation.runner import NotAtHand, Workers, staying
from dolfingrip.diagnosis.simulation.simulated import simulate
from dolfingrip.experiments.synthetic import NOISE
from dolfingrip.files.plan import AdditionWorth, EffectOutlook, PlanFile
from dolfingrip.jobs.run import Progress, silent


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
        NotAtHand: simulations are missing, and the workers do not compute.
    """
    if in_closed_form(measurement, config):
        told = _reading(measurement, CouponSimulation(measurement, config).base())
        return analyse_coupons(CouponSimulation(told, config), names)
    wanted = base_variant(measurement, config)
    (base,) = simulate(measurement, config, [wanted], workers)
    if np.isnan(base.readings).any():
        why = "; ".join(dict.fromkeys(each.sentence for each in base.failures))
        raise ConfigError(f"the simulation does not reach all readings: {why}")
    told = _reading(measurement, base.readings)
    return analyse_fingers(told, config, workers, names, fully=True)


def _reading(measurement: Measurement, values: np.ndarray) -> Measurement:
    """The measurement with these readings, shape (n,)."""
    rows = measurement.readings.copy()
    places = measurement.listed()[["row", "column"]].itertuples(index=False)
    for (row, column), value in zip(places, values, strict=True):
        rows.loc[rows.index[row], column] = value
    return Measurement(rows, measurement.tests, measurement.warnings)


def joined(first: Measurement, second: Measurement) -> Measurement:
    """Both together, without tests of the second that nothing is read of."""
    read = set(second.listed()["test"])
    later = second.of(read, len(first.tests))
    both = pd.concat([first.readings, later.readings], ignore_index=True)
    return Measurement(both, [*first.tests, *later.tests], first.warnings)


ALONE: Final = (
    "these effects alone were compared: one that is named among them may still be like another "
    "of the catalogue"
)
"""Said where effects were chosen."""


@dataclass(frozen=True)
class PlanSettings:
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
    settings: PlanSettings,
    changes: Mapping[str, Any] = MappingProxyType({}),
    noise: Mapping[str, float] | None = None,
) -> PlanFile:
    """Plan: tell which causes a rig could name, and which addition buys most.

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
        own = analyse_plan(measurement, config, workers, names)
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
                more = namings(analyse_plan(whole, config, hands, names), found)
            except (NotAtHand, ConfigError) as failure:
                failed.append(f"{proposal.name} could not be judged: {failure}")
                continue
            additions.append(_addition_worth(proposal, found, before, more))
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


def _addition_worth(
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
