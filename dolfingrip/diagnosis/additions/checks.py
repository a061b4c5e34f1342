"""Numbers that a laboratory can read by themselves, and what it has read.

A check that is advised and a reading that is told have the same key: that of ``[nuisance]``. There
``KEY = {value = 1.83, std = 0.05}`` is a reading of the number, beside all others in the
likelihood. The model as configured stays. So a number that is read far from what is configured is
evidence for the cause whose number it is.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np

from dolfingrip.channels import Part
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.core.unknown import MODULUS, NumberReading
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.experiments.derivatives.gradients import MASS, shape_number
from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import EFFECTS, camera_errors
from dolfingrip.extensions.kinds import DimensionOffset
from dolfingrip.files.diagnosis import PlannedQuantity
from dolfingrip.parameter import find
from dolfingrip.sections.section import EVERYWHERE
from dolfingrip.sections.units import unit

COUPON: Final = 0.1 / 2
"""Standard deviation of a modulus by a coupon of another print, relative."""


@dataclass(frozen=True, slots=True)
class NumberCheck:
    """A measurement of numbers by themselves.

    Attributes:
        name: in words.
        minutes: that it takes, an engineering guess.
        readings: with engineering guesses of usual tools' standard deviations.
    """

    name: str
    minutes: float
    readings: tuple[NumberReading, ...]
    tests: ClassVar = ()

    @property
    def columns(self) -> list[str]:
        """Nothing for each reading, which is of no channel."""
        return [""] * len(self.readings)

    @property
    def quantities(self) -> tuple[PlannedQuantity, ...]:
        """Quantities to read, as a result file tells them."""
        return tuple(
            PlannedQuantity(
                key=reading.key, unit=unit(reading.key), configured=reading.configured,
                std=reading.std, numbers=dict(reading.numbers),
            )
            for reading in self.readings
        )  # fmt: skip

    @property
    def std(self) -> np.ndarray:
        """Standard deviation of each reading, shape (m,)."""
        return np.array([reading.std for reading in self.readings])


def coupon_check(policy: Policy, factor: float = 1.0) -> NumberCheck:
    """The modulus by a coupon of another print.

    Args:
        policy: how long it takes.
        factor: that is expected of all moduli, by those configured.
    """
    read = NumberReading(MODULUS, {MODULUS: 1.0}, {MODULUS: 1.0}, 1.0, COUPON * factor)
    return NumberCheck("a coupon in uniaxial tension", policy.set_up_min["coupon"], (read,))


def checks(config: Config, parts: Collection[Part] = EVERYWHERE) -> list[NumberCheck]:
    """List what can be measured by itself of a body and its rig, as its effects tell.

    Args:
        config: of the body, as it was drawn.
        parts: of the rigs that it is measured on.
    """
    read: dict[tuple[str, float], list[NumberReading]] = defaultdict(list)
    shapes: dict[str, NumberReading] = {}
    for cls in (effect for effect in EFFECTS if effect.felt_on(parts)):
        for check in cls.checks:
            for key, std in check.std.items():
                if (reading := _of(cls, key, config, std)) is not None:
                    read[check.name, check.minutes].append(reading)
                    if issubclass(cls, DimensionOffset):
                        shapes[reading.key] = reading
    single = [NumberCheck(*called, tuple(readings)) for called, readings in read.items()]
    return [_weighed(config, shapes), *single] if shapes else single


def _of(cls: type[Effect], key: str, config: Config, std: float) -> NumberReading | None:
    """A reading of an effect's number; None where the body has no such number."""
    fitted = cls.fitted(config) if cls.told.key else None
    number = fitted.key if fitted else f"extensions.{cls.name()}.{key}"
    start = fitted.value if fitted else float(cls.neutral.get(key, 0.0))
    read_by, configured = number, start
    if issubclass(cls, DimensionOffset):
        dimension = cls.dimension_key(config)
        if dimension is None:
            return None
        read_by, (parameter,) = dimension, find(config, (dimension,))
        configured = parameter.value(config)
    return NumberReading(read_by, {number: 1.0}, {number: start}, configured, std)


def _weighed(config: Config, shapes: Mapping[str, NumberReading]) -> NumberCheck:
    """The mass, which tells the sum of what all dimensions change of it.

    Args:
        config: of the body.
        shapes: readings of dimensions, by the dimension's key.
    """
    check = DimensionOffset.weighed
    mass_g, by = shape_number(MASS, config, find(config, tuple(shapes)))
    numbers, starts = dict[str, float](), dict[str, float]()
    for key, slope in by.items():
        numbers |= dict.fromkeys(shapes[key].numbers, slope)
        starts |= shapes[key].starts
    mass = NumberReading(MASS, numbers, starts, mass_g, check.std[MASS] * mass_g)
    return NumberCheck(check.name, check.minutes, (mass,))


def numbers_read(measurement: Measurement, config: Config) -> tuple[NumberReading, ...]:
    """List the numbers that a laboratory has read by themselves, as its set-ups tell.

    What it told a standard deviation of, too, may differ from its prior by so much more.

    Args:
        measurement: with the set-ups; a number that several tell is one reading.
        config: the model that is diagnosed.

    Raises:
        ConfigError: one line with the key, its value and what is allowed.
    """
    pairs: dict[str, tuple[float, float]] = {}
    for test in measurement.tests:
        for key, pair in test.setup.numbers.items():
            if pairs.setdefault(key, pair) != pair:
                raise ConfigError(
                    f"[nuisance] {key} = {pair[0]:g} ± {pair[1]:g} in {test.file}: allowed: "
                    f"{pairs[key][0]:g} ± {pairs[key][1]:g}, as in another file"
                )
    if not pairs:
        return ()
    body = measurement.tests[0].applied(config)
    every = [*checks(body), coupon_check(measurement.policy)]
    possible = {reading.key: reading for check in every for reading in check.readings}
    believed = {
        f"extensions.{cls.name()}.{key}": max(
            report.spread(test.setup.nuisances[report.key], float(cls.neutral[key]))
            for test in measurement.tests
        )
        for cls in camera_errors() for key, report in cls.told_by.items()
    }  # fmt: skip
    for key, (value, _) in pairs.items():
        if key not in possible:
            raise ConfigError(
                f"[nuisance] {key} = {value:g}: no effect tells how it is read; allowed: "
                f"{', '.join(sorted(possible))}"
            )
    return tuple(
        replace(possible[key], value=value, std=float(np.hypot(std, believed.get(key, 0.0))))
        for key, (value, std) in pairs.items()
    )
