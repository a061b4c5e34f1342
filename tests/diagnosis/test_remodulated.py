"""An instrument's effect that the base model imitates by another modulus."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dolfingrip.config import Config
from dolfingrip.diagnosis import conclude
from dolfingrip.diagnosis.conclude import NONE
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.diagnose import problem_of
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.linear import beside_own_modulus
from dolfingrip.diagnosis.remodulated import GAIN, remodulated
from dolfingrip.diagnosis.simulation.base import simulate_base
from dolfingrip.diagnosis.simulation.reference import reference_measurement
from dolfingrip.diagnosis.workers import StayingWorkers, staying

TRIED = ("angle_definition", "angle_gain", "force_gain", "force_offset")
SHARE = 0.45
"""Of the chord in what is taken for the tip's angle: it reads 20 % low at all pressures."""


@pytest.fixture(scope="module")
def workers(store: Path) -> Iterator[StayingWorkers]:
    """The reference finger's simulations come with the package: none is computed."""
    with staying(store, 1, lambda standing: None) as found:
        yield found


def measured(workers: StayingWorkers, share: float) -> Measurement:
    """Angle and force as simulated, without noise; the angle in part the chord's."""
    asked = reference_measurement(1, unload=False)
    listed = asked.listed()
    simulated = simulate_base(asked, Config(), workers, effects=()).readings
    table = asked.readings.copy()
    true = {
        (int(row), str(column)): value
        for row, column, value in zip(listed["row"], listed["column"], simulated, strict=True)
    }
    for row in range(len(table)):
        bends = table.loc[row, "experiment"] == "bending"
        face, chord = true[row, "angle_deg"], true[row, "chord_angle_deg"]
        table.loc[row, "angle_deg"] = (1 - share) * face + share * chord if bends else np.nan
        table.loc[row, "force_N"] = np.nan if bends else true[row, "force_N"]
    table[["chord_angle_deg", "tip_x_mm", "tip_z_mm"]] = np.nan
    return replace(asked, readings=table)


def fitted(workers: StayingWorkers, share: float) -> tuple[Fitter, conclude.Conclusion]:
    """The base model's fit to such a measurement, and the screen about it."""
    measurement = measured(workers, share)
    base = simulate_base(measurement, Config(), workers, effects=TRIED)
    problem, _ = problem_of(measurement, base)
    fitter = Fitter(problem, workers, lambda text: None)
    none = fitter.none()
    return fitter, conclude.conclude(problem, conclude.screen(problem, none), {NONE: none})


def test_the_chord_is_found_beside_the_modulus_that_is_there(workers: StayingWorkers) -> None:
    """What is hidden: a modulus as configured, and SHARE. Alone, the modulus takes most of it."""
    fitter, screened = fitted(workers, SHARE)
    none = fitter.none()
    assert none.values[0] > 1.3
    score = next(each for each in screened.scores if each.name == "angle_definition")
    found = remodulated(fitter, screened.scores, none)
    assert frozenset(["angle_definition"]) in found
    fit = found[frozenset(["angle_definition"])]
    problem = fitter.problem
    reached = fit.log_evidence(problem) - none.log_evidence(problem)
    print("log evidence in the screen", score.log_evidence, "beside its modulus", reached)
    assert reached > max(score.log_evidence + GAIN, 5.0)
    modulus = fit.estimates(problem)[0]
    assert modulus.low < 1.0 < modulus.high
    (told,) = (text for text in fit.overrides if "chord_share" in text)
    assert float(told.partition("=")[2]) == pytest.approx(SHARE, abs=0.1)


def test_what_the_readings_do_not_ask_for_stays_as_it_was(workers: StayingWorkers) -> None:
    """Without a cause no effect gains; one of the other sign is none."""
    fitter, screened = fitted(workers, 0.0)
    assert remodulated(fitter, screened.scores, fitter.none()) == {}
    fitter, screened = fitted(workers, -0.2)
    none = fitter.none()
    score = next(each for each in screened.scores if each.name == "angle_definition")
    candidate = fitter.linear(score)
    assert candidate is not None
    assert beside_own_modulus(fitter.problem, none, score, candidate).zeta[-1] == 0.0
    assert frozenset(["angle_definition"]) not in remodulated(fitter, screened.scores, none)
