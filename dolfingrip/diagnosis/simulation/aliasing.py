"""Whether the rows of a record are close enough to show the model's slowest swing."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from dolfingrip.channels import FREQUENCIES, TIME
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.runner import Workers, request


def undersampled(measurement: Measurement, config: Config, workers: Workers) -> list[str]:
    """Say which records show the model's slowest swing too seldom, by its natural frequency.

    Args:
        measurement: what was measured.
        config: the model.
        workers: that compute the frequency of each set-up with inertia.
    """
    slight = {"min_pressure_kPa": 0.0, "max_pressure_kPa": 1.0, "step_kPa": 1.0}
    moving = [
        (test, applied.at_rest().changed(experiment=slight))
        for test, applied in zip(measurement.tests, measurement.applied(config), strict=True)
        if applied.experiment.dynamic and not test.small_vibrations
    ]
    lines = []
    with suppress(ConfigError):  # a mesh of half a body has no swings across
        wanted = [request("vibration", still) for _, still in moving]
        answers = workers.results(wanted) if wanted else []
        for (test, _), answer in zip(moving, answers, strict=True):
            steps = np.diff(np.unique(measurement.rows(test.number)[TIME.name]))
            swings = answer.columns.get(FREQUENCIES[0].name)
            doubt = aliased(float(np.median(steps)), swings[0]) if swings else ""
            lines += [f"{test}: {doubt}"] if doubt else []
    return lines


def aliased(apart_s: float, frequency_Hz: float) -> str:
    """Say that rows are too far apart to show a swing; nothing where they are not.

    Args:
        apart_s: usual step between two rows.
        frequency_Hz: of the model's slowest swing.
    """
    shown_Hz = 0.5 / apart_s
    if frequency_Hz <= shown_Hz:
        return ""
    return (
        f"its rows are {apart_s:.2g} s apart and show swings of up to {shown_Hz:.3g} Hz, but the "
        f"model's slowest one has {frequency_Hz:.3g} Hz, which looks slower than it is; rows at "
        f"most {0.5 / frequency_Hz:.2g} s apart show it"
    )
