"""Slips of units, signs and columns that show if readings are compared with a simulation.

A wrong unit multiplies a column by a known number, and so explains the readings far better than 1
does. A pressure in the wrong unit was simulated at pressures that are as much too small; as the
response is nearly proportional at first, every reading is then too large by about that number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from dolfingrip.channels import ANGLE, CHANNELS, FORCE
from dolfingrip.diagnosis.data.columns import READING_COLUMNS
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest

NEAR: Final = 1.8
"""A ratio counts as a known factor where it is off by no more than this factor: what a simple model
may be wrong by, and by how much the response is not proportional."""

FAR: Final = 2.5
"""A ratio within this factor of 1 is no slip."""

BETTER: Final = 0.6
"""A scale has to bring what is left unexplained down to this part."""

_DEGREES: Final = 180 / math.pi


@dataclass(frozen=True, slots=True)
class Factor:
    """A slip: what the column is multiplied by to be right, and in words what was done."""

    value: float
    meaning: str


_OF_READING: Final[Mapping[str, Sequence[Factor]]] = {
    "deg": (
        Factor(_DEGREES, "an angle in radians"),
        Factor(1 / _DEGREES, "degrees turned twice"),
    ),
    "N": (
        Factor(1 / 101.97, "a force in grams"),
        Factor(1 / 1000, "a force in mN"),
        Factor(9.81, "a force in kg"),
        Factor(1 / 9.81, "a force multiplied by g"),
    ),
    "mm": (Factor(1000.0, "a length in m"), Factor(10.0, "a length in cm")),
    "": (Factor(0.01, "a strain in percent"),),
}
"""By the channel's unit."""

_OF_CONTROL: Final[Mapping[str, Sequence[Factor]]] = {
    "kPa": (
        Factor(100.0, "a pressure in bar"),
        Factor(1000.0, "a pressure in MPa"),
        Factor(6.895, "a pressure in psi"),
    ),
    "mm": (Factor(1000.0, "a displacement in m"), Factor(10.0, "a displacement in cm")),
}
"""By the control's unit."""


@dataclass(frozen=True, slots=True)
class Suspicion:
    """What may be wrong with a column of a test.

    Attributes:
        test: whose.
        column: that may be wrong.
        factor: what it is to be multiplied by; NaN where columns are swapped.
        meaning: what was done, in words.
        left: what a scale in place of 1 leaves unexplained, as part of what 1 does.
    """

    test: SpecimenTest
    column: str
    factor: float
    meaning: str
    left: float

    def sentence(self) -> str:
        """For the verdict."""
        if math.isnan(self.factor):
            return f"{self.test}: {self.column}: {self.meaning}?"
        return f"{self.test}: {self.column}: {self.meaning}? (factor {self.factor:.4g})"


def suspicions(measurement: Measurement, simulated: np.ndarray) -> list[Suspicion]:
    """What a comparison with the base simulation casts doubt on.

    Args:
        measurement: the readings.
        simulated: (n,) the base model's, aligned with ``measurement.listed()``; NaN where there
            is none.

    Returns:
        For each test what explains its readings far better than taking them as they are. Where
        several slips would do, all of them.
    """
    listed = measurement.listed().assign(simulated=simulated)
    found: list[Suspicion] = []
    for number, part in listed.dropna(subset="simulated").groupby("test", sort=True):
        test = measurement.tests[int(number)]
        columns = {
            str(name): (rows["value"].to_numpy(), rows["simulated"].to_numpy())
            for name, rows in part.groupby("column", sort=False)
        }
        swapped = _swapped(test, columns)
        found += swapped or _scaled(test, columns)
    return found


def _scaled(
    test: SpecimenTest, columns: dict[str, tuple[np.ndarray, np.ndarray]]
) -> list[Suspicion]:
    """Slips of unit or sign."""
    ratios = {name: _ratio(*pair) for name, pair in columns.items() if len(pair[0]) > 1}
    usable = {name: ratio for name, ratio in ratios.items() if math.isfinite(ratio)}
    found: list[Suspicion] = []
    for name, ratio in usable.items():
        if ratio < 0 and 1 / FAR < -ratio < FAR:
            found += _kept(test, name, [Factor(-1.0, "the sign is reversed")], columns[name])
            continue
        known = _OF_READING.get(CHANNELS[name].unit, ())
        off = [f for f in known if _alike(abs(ratio), 1 / f.value)]
        off = [Factor(math.copysign(f.value, ratio), f.meaning) for f in off]
        found += _kept(test, name, off, columns[name])
    found += _of_control(test, usable, columns)
    return found


def _of_control(
    test: SpecimenTest,
    ratios: dict[str, float],
    columns: dict[str, tuple[np.ndarray, np.ndarray]],
) -> list[Suspicion]:
    """Slips of the pressure's or displacement's unit, which every reading shows."""
    known = _OF_CONTROL[CHANNELS[test.control].unit]
    found = []
    for factor in known:
        if not ratios or not all(_alike(ratio, factor.value) for ratio in ratios.values()):
            continue
        left = max(_left(*columns[name], ratio) for name, ratio in ratios.items())
        if left < BETTER:
            found.append(Suspicion(test, test.control, factor.value, factor.meaning, left))
    return found


def _kept(
    test: SpecimenTest,
    column: str,
    factors: Sequence[Factor],
    pair: tuple[np.ndarray, np.ndarray],
) -> list[Suspicion]:
    """The slips that go with the ratio of measured and simulated, where that explains enough."""
    left = _left(*pair, _ratio(*pair))
    if left >= BETTER:
        return []
    return [Suspicion(test, column, each.value, each.meaning, left) for each in factors]


def _swapped(
    test: SpecimenTest, columns: dict[str, tuple[np.ndarray, np.ndarray]]
) -> list[Suspicion]:
    """Whether an angle's readings are a force's, and the other way round."""
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
        if crossed < BETTER * straight and crossed < 1:
            meaning = f"swapped with {other}, {angle} and {other} fit far better so"
            return [Suspicion(test, angle, math.nan, meaning, crossed / straight)]
    return []


def _alike(ratio: float, factor: float) -> bool:
    """Whether a ratio is about a factor, and far from 1."""
    if ratio <= 0 or 1 / FAR < ratio < FAR:
        return False
    return abs(math.log(ratio / factor)) < math.log(NEAR)


def _ratio(measured: np.ndarray, simulated: np.ndarray) -> float:
    """Measured by simulated, by least squares; NaN where either is nothing."""
    square = float(simulated @ simulated)
    return float(measured @ simulated) / square if square > 0 else math.nan


def _left(measured: np.ndarray, simulated: np.ndarray, ratio: float) -> float:
    """Unexplained with a factor, as part of unexplained without."""
    before = float(np.linalg.norm(measured - simulated))
    return float(np.linalg.norm(measured - ratio * simulated)) / before if before > 0 else 1.0


def _misfit(measured: np.ndarray, simulated: np.ndarray) -> float:
    """Unexplained, as part of the larger of both."""
    size = max(float(np.linalg.norm(measured)), float(np.linalg.norm(simulated)))
    return float(np.linalg.norm(measured - simulated)) / size if size > 0 else 0.0
