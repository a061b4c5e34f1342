"""Effects whose change of the readings follows from the base simulation alone.

Instruments display a function of the true readings, so theirs is exact. Those of the regulator, of
the plate's gap and of printed dimensions are their parameter's forward sensitivity times the
ordinary strength: nuisances have the same columns, and over their priors they are nearly linear.
"""

from __future__ import annotations

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.simulated import Simulated
from dolfingrip.diagnosis.simulation.strengths import TriedEffect
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import find


def has_closed_form(name: str) -> bool:
    """Whether an effect needs no simulation of its own."""
    return bool(effect(name).slopes()) or effect(name).has("reading")


def changes(
    measurement: Measurement, config: Config, base: Simulated, tried: TriedEffect
) -> np.ndarray:
    """(k, n) changes of the readings by the shapes of an effect, at its ordinary strength.

    Args:
        measurement: that ``base`` was simulated for.
        config: without the effect.
        base: with the gradients ``nuisances.keys``.
        tried: an effect for which :func:`has_closed_form` is true.
    """
    keys = effect(tried.effect).slopes()
    if keys:
        slope = np.sum([base.slope(key) for key in keys], axis=0)
        return np.array([slope * _step(config, tried, shape.overrides) for shape in tried.shapes])
    return np.array(
        [
            _displayed(measurement, config, base, tried.effect, shape.overrides)
            for shape in tried.shapes
        ]
    )


def _step(config: Config, tried: TriedEffect, overrides: tuple[str, ...]) -> float:
    """From the neutral value to a shape's."""
    (key,) = effect(tried.effect).neutral
    (parameter,) = find(config.overridden(overrides), [f"extensions.{tried.effect}.{key}"])
    value = parameter.value(config.overridden(overrides))
    return value - float(effect(tried.effect).neutral[key])


def _displayed(
    measurement: Measurement,
    config: Config,
    base: Simulated,
    name: str,
    overrides: tuple[str, ...],
) -> np.ndarray:
    """(n,) what an instrument displays, less the true readings."""
    instrument = getattr(config.overridden(overrides).extensions, name)
    listed = measurement.listed()
    place, column, test = (listed[key].to_numpy() for key in ("row", "column", "test"))
    readings, count = measurement.readings, len(measurement.readings)
    time_s = readings["time_s"] - readings.groupby("test")["time_s"].transform("first")
    found = np.zeros(len(listed))
    for run in base.runs:
        true = {
            key: run.route.at_rows(values, count)
            for key, values in run.result.columns.items()
            if key != "time_s"
        }
        shown = instrument.reading({**true, "time_s": time_s.to_numpy()})
        for key, values in shown.items():
            at = np.flatnonzero(np.isin(test, run.group.tests) & (column == key))
            found[at] = (values - true[key])[place[at]]
    return found
