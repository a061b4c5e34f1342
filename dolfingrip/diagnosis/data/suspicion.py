"""Slips of units, signs and columns that show if readings are compared with a simulation.

A wrong unit multiplies a column by a known factor, which therefore explains the readings far better
than 1 does. Pressures in the wrong unit were also simulated, and they are too small by a known
factor. The response is nearly proportional at first, so every reading is then too large by about
this factor.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from itertools import product
from typing import Final

import numpy as np
import pandas as pd
from numpy.polynomial import Polynomial

from dolfingrip.channels import ANGLE, CHANNELS, DISPLACEMENT, FORCE, PRESSURE
from dolfingrip.config import Config
from dolfingrip.diagnosis.data.lab_setup import STANDARD_GRAVITY_m_s2
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.data.table import READING_COLUMNS
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.files.diagnosis import Slip

_DEGREES: Final = 180 / math.pi


_REVERSED: Final = "the sign is reversed"

SIGNED: Final = (ANGLE.unit, FORCE.unit)
"""Units of readings that rise with the pressure, or with a coupon's travel."""

_OF_READING: Final[Mapping[str, Mapping[str, float]]] = {
    "deg": {"an angle in radians": _DEGREES, "degrees turned twice": 1 / _DEGREES},
    "N": {
        "a force in grams": STANDARD_GRAVITY_m_s2 / 1000,
        "a force in mN": 1 / 1000,
        "a force in kN": 1000.0,
        "a force in kg": STANDARD_GRAVITY_m_s2,
        "a force multiplied by g": 1 / STANDARD_GRAVITY_m_s2,
    },
    "mm": {"a length in m": 1000.0, "a length in cm": 10.0},
    "": {"a strain in percent": 0.01},
}
"""Slips by the channel's unit: the mistake in words, and the factor that makes the column right."""

_OF_CONTROL: Final[Mapping[str, Mapping[str, float]]] = {
    "kPa": {"a pressure in bar": 100.0, "a pressure in MPa": 1000.0, "a pressure in psi": 6.895},
    "mm": {"a displacement in m": 1000.0, "a displacement in cm": 10.0},
}
"""Slips of the control, by its unit."""


_EVENLY: Final = {
    DISPLACEMENT.name: (FORCE.name, "time_s"),
    PRESSURE.name: (ANGLE.name, "order"),
}
"""The reading that a control may be swapped with, and what the control itself rises evenly in."""

_RISES: Final = {
    "time_s": "evenly in time, as a machine's travel",
    "order": "by equal steps, as a regulator's pressure",
}
"""How a control rises, by what it rises in."""


Pairs = Mapping[str, tuple[np.ndarray, np.ndarray]]
"""Measured and simulated readings, by column."""


Raised = list[tuple[SpecimenTest, Slip]]
"""Doubts, each with its test."""


def suspicions(measurement: Measurement, simulated: np.ndarray) -> list[Slip]:
    """The slips that are suspected from a comparison with the base simulation.

    Args:
        measurement: the readings.
        simulated: (n,) readings of the base model, as in ``measurement.listed``; NaN where there
            is none.

    Returns:
        All slips that explain the readings of a test far better than no slip; those that several
        specimens show alike once.
    """
    listed = measurement.listed.assign(simulated=simulated)
    raised: Raised = []
    for number, part in listed.dropna(subset="simulated").groupby("test", sort=True):
        test = measurement.tests[int(number)]
        columns = {
            str(name): (rows["value"].to_numpy(), rows["simulated"].to_numpy())
            for name, rows in part.groupby("column", sort=False)
        }
        rows = measurement.rows(int(number))
        swapped = _swapped(test, columns) or _swapped_with_control(test, rows, measurement.policy)
        raised += swapped or _scaled(test, columns, rows, measurement.policy)
    return _once(raised)


def reversed_signs(measurement: Measurement, config: Config) -> list[Slip]:
    """The signs that the readings tell without a simulation, as every finger bends to its back.

    Args:
        measurement: the readings.
        config: the model; a mesh of one's own may bend to either side.

    Returns:
        A slip of each angle and force that falls as steadily as its control rises; those that
        several specimens show alike once.
    """
    raised: Raised = []
    for test in measurement.tests:
        rows = measurement.rows(test.number)
        applied = test.applied(config)
        if test.of_finger and (test.supplies or applied.mesh.file or applied.geometry.of_file):
            continue
        for name in (column for column in READING_COLUMNS if CHANNELS[column].unit in SIGNED):
            pairs = rows[[test.control, name]].dropna()
            if len(pairs) < measurement.policy.few or not pairs.std().all():
                continue
            if pairs.corr().iloc[0, 1] < -measurement.policy.nearly:
                raised.append(_slip(test, name, _REVERSED, -1.0))
    return _once(raised)


def _slip(
    test: SpecimenTest, column: str, meaning: str, factor: float | None
) -> tuple[SpecimenTest, Slip]:
    """A doubt about a column of a test; no factor where columns are swapped."""
    return test, Slip(where=str(test), column=column, meaning=meaning, factor=factor)


def _once(raised: Raised) -> list[Slip]:
    """Tell what several specimens raise alike once."""
    alike = defaultdict[tuple[str, str], Raised](list)
    for test, slip in raised:
        alike[slip.column, slip.meaning].append((test, slip))
    merged = []
    for (test, slip), *others in alike.values():
        several = f"{test.experiment}, {len(others) + 1} specimens ({test.file.name})"
        merged.append(slip.model_copy(update={"where": several}) if others else slip)
    return merged


def _swapped_with_control(test: SpecimenTest, rows: pd.DataFrame, policy: Policy) -> Raised:
    """The suspicion that the control and a reading are swapped.

    A machine moves evenly in time, and a force does not rise so. A regulator's set points rise by
    equal steps, and an angle does not.
    """
    if test.control not in _EVENLY:
        return []
    name, evenly = _EVENLY[test.control]
    rows = rows.assign(order=np.arange(len(rows)))
    first = rows[(rows["cycle"] == 1) & (rows["branch"] == "loading")].dropna(subset=name)
    if len(first) < policy.few or np.ptp(first[evenly]) <= 0:
        return []
    control, reading = (_unevenness(first, column, evenly) for column in (test.control, name))
    if control < policy.alike or reading > control / policy.more_even:
        return []
    meaning = f"swapped with {name}, which rises {_RISES[evenly]} does"
    return [_slip(test, test.control, meaning, None)]


def _unevenness(rows: pd.DataFrame, column: str, evenly: str) -> float:
    """Largest distance of a column from a line in another one, by its range."""
    value, along = rows[column].to_numpy(), rows[evenly].to_numpy()
    line = Polynomial.fit(along, value, 1)(along)
    return float(np.abs(value - line).max() / max(np.ptp(value), 1e-12))


def _scaled(test: SpecimenTest, columns: Pairs, rows: pd.DataFrame, policy: Policy) -> Raised:
    """Slips of unit or sign: of one reading, or of the control, which every reading shows."""
    every = {name: _ratio(*pair) for name, pair in columns.items() if len(pair[0]) > 1}
    ratios = {name: ratio for name, ratio in every.items() if math.isfinite(ratio)}
    left = {name: _left(*columns[name], ratio) for name, ratio in ratios.items()}
    raised: Raised = []
    for name, ratio in ratios.items():
        measured, simulated = columns[name]
        # readings of noise alone are near any small multiple, which explains nothing of them
        missed = np.linalg.norm(measured - ratio * simulated)
        if left[name] >= 0.5 or missed >= 0.5 * np.linalg.norm(measured):
            continue
        slips = list(_OF_READING.get(CHANNELS[name].unit, {}).items())
        alike = [slip for slip in slips if _alike(abs(ratio), 1 / slip[1], policy)]
        if slips and not alike and ratio > 0 and not 1 / policy.stiffest < ratio < policy.stiffest:
            # no material is so far from the configured one: the nearest slip, if it is as near
            nearest = min(slips, key=lambda slip: abs(math.log(ratio * slip[1])))
            off = ratio * nearest[1]
            alike = [nearest] if 1 / policy.stiffest < off < policy.stiffest else []
        if ratio < 0 and not alike:  # however much softer or stiffer the finger is, too
            alike = [(_REVERSED, 1.0)]
        raised += [
            _slip(test, name, meaning, math.copysign(factor, ratio)) for meaning, factor in alike
        ]
        if alike and _exchanged(test, name, rows, ratio, policy):
            meaning = f"swapped with {test.control}, which the readings cannot tell from a unit"
            raised.append(_slip(test, name, meaning, None))
    if max(left.values(), default=1.0) < 0.5:
        raised += [
            _slip(test, test.control, meaning, factor)
            for meaning, factor in _OF_CONTROL.get(CHANNELS[test.prescribed].unit, {}).items()
            if all(_alike(ratio, factor, policy) for ratio in ratios.values())
        ]
    return raised


def _exchanged(
    test: SpecimenTest, name: str, rows: pd.DataFrame, ratio: float, policy: Policy
) -> bool:
    """Tell whether no material explains a ratio, but one does if an angle is the pressure.

    The response is nearly proportional at first, so that the steepness of exchanged columns is 1 by
    that of the columns.
    """
    if CHANNELS[name].unit != ANGLE.unit or test.control != PRESSURE.name:
        return False
    pairs = rows[[name, test.control]].dropna()
    steep = _ratio(pairs[name].to_numpy(), pairs[test.control].to_numpy())
    if not steep > 0 or 1 / policy.stiffest < ratio < policy.stiffest:
        return False
    return 1 / policy.stiffest < ratio / steep**2 < policy.stiffest


def _swapped(test: SpecimenTest, columns: Pairs) -> Raised:
    """The suspicion that the columns of angle and force are swapped."""
    angles, forces = (
        [name for name in READING_COLUMNS if name in columns and CHANNELS[name].unit == unit]
        for unit in (ANGLE.unit, FORCE.unit)
    )
    for angle, other in product(angles, forces):
        (turned, turned_simulated), (force, force_simulated) = columns[angle], columns[other]
        if len(turned) != len(force):
            continue
        straight = _misfit(turned, turned_simulated) + _misfit(force, force_simulated)
        crossed = _misfit(turned, force_simulated) + _misfit(force, turned_simulated)
        if crossed < 0.5 * straight and crossed < 1:
            meaning = f"swapped with {other}, {angle} and {other} fit far better so"
            return [_slip(test, angle, meaning, None)]
    return []


def _alike(ratio: float, factor: float, policy: Policy) -> bool:
    """Tell whether a ratio is close to a factor and not close to 1."""
    if ratio <= 0 or 1 / policy.no_slip < ratio < policy.no_slip:
        return False
    return abs(math.log(ratio / factor)) < math.log(policy.slip)


def _ratio(measured: np.ndarray, simulated: np.ndarray) -> float:
    """Ratio of measured and simulated readings by least squares; NaN if either is 0."""
    square = float(simulated @ simulated)
    return float(measured @ simulated) / square if square > 0 else math.nan


def _left(measured: np.ndarray, simulated: np.ndarray, ratio: float) -> float:
    """Ratio of the unexplained changes with and without a factor."""
    before = float(np.linalg.norm(measured - simulated))
    return float(np.linalg.norm(measured - ratio * simulated)) / before if before > 0 else 1.0


def _misfit(measured: np.ndarray, simulated: np.ndarray) -> float:
    """Unexplained change, divided by the larger one of both readings."""
    size = max(float(np.linalg.norm(measured)), float(np.linalg.norm(simulated)))
    return float(np.linalg.norm(measured - simulated)) / size if size > 0 else 0.0
