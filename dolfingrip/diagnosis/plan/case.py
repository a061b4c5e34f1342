"""Readings that a rig would take, as the case that a diagnosis of them would be made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.answer.analysed import Analysed
from dolfingrip.diagnosis.coupon.case import coupon_case
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation, in_closed_form
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.finger.case import finger_case
from dolfingrip.diagnosis.policy import ROUTES
from dolfingrip.diagnosis.simulation import simulated
from dolfingrip.diagnosis.simulation.nuisances import keys, neutral_stages
from dolfingrip.diagnosis.simulation.runner import Workers


def planned_case(
    measurement: Measurement, config: Config, workers: Workers, names: Sequence[str] | None
) -> Analysed[Any]:
    """The case of a measurement that is still to be made.

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
        return coupon_case(told, config, names)
    wanted = simulated.Case(
        neutral_stages(config), keys(measurement, config), headroom=ROUTES.headroom
    )
    (base,) = simulated.simulate(measurement, config, [wanted], workers)
    if np.isnan(base.readings).any():
        why = "; ".join(dict.fromkeys(each.sentence for each in base.failures))
        raise ConfigError(f"the simulation does not reach all readings: {why}")
    finger = finger_case(_reading(measurement, base.readings), config, workers, names, fully=True)
    causes = {name: each for name, each in finger.causes.items() if name not in finger.case.rig}
    return replace(finger, causes=causes)


def _reading(measurement: Measurement, values: np.ndarray) -> Measurement:
    """The measurement with these readings, shape (n,)."""
    rows = measurement.readings.copy()
    places = measurement.listed()[["row", "column"]].itertuples(index=False)
    for (row, column), value in zip(places, values, strict=True):
        rows.loc[rows.index[row], column] = value
    return Measurement(rows, measurement.tests, measurement.warnings)


def joined(first: Measurement, second: Measurement) -> Measurement:
    """Both together, without tests of the second that nothing is read of."""
    read = sorted(set(second.listed()["test"]))
    number = {old: len(first.tests) + place for place, old in enumerate(read)}
    rows = second.readings[second.readings["test"].isin(read)]
    later = rows.assign(test=rows["test"].map(number))
    tests = [replace(t, number=number[t.number]) for t in second.tests if t.number in number]
    both = pd.concat([first.readings, later], ignore_index=True)
    return Measurement(both, [*first.tests, *tests], first.warnings)
