"""Nuisances: numbers that a laboratory never knows exactly, and no diagnosis names as a cause.

Each is a change of all readings at one standard deviation. They come from the forward
sensitivities of one base simulation; the numbers are those of
:func:`dolfingrip.parameter.nuisances.known`, or the laboratory's own, in the table
``[nuisance]`` of its TOML. There it can give any parameter of the configuration one, too. A
modulus that is far off is not linear: see :mod:`dolfingrip.diagnosis.simulation.simulated`.
"""

from __future__ import annotations

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.core.unknown import MODULUS, Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest, in_proportion
from dolfingrip.diagnosis.simulation.simulated import SimulatedReadings
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.extensions.effect import Effect, FittedKey
from dolfingrip.extensions.index import fitted_effects
from dolfingrip.parameter import every, named
from dolfingrip.parameter.nuisances import SPECIMEN, changes, known, modulus_keys
from dolfingrip.sections import units


def feels(each: type[Effect], test: SpecimenTest) -> bool:
    """Tell whether a test is of a finger whose rig feels an effect.

    Args:
        each: the effect.
        test: one of a measurement.
    """
    return test.of_finger and each.felt_on(EXPERIMENTS[test.experiment].parts)


def fitted_in(
    each: type[Effect], measurement: Measurement, config: Config
) -> list[tuple[SpecimenTest, FittedKey]]:
    """List the tests that feel an effect, with the number by which each fits it.

    Args:
        each: an effect that every hypothesis fits.
        measurement: with the tests.
        config: the model that is diagnosed.
    """
    every_test = zip(measurement.tests, measurement.applied(config), strict=True)
    numbers = [(test, each.fitted(own)) for test, own in every_test if feels(each, test)]
    return [(test, number) for test, number in numbers if number is not None]


def keys(measurement: Measurement, config: Config) -> tuple[str, ...]:
    """Parameters that a base simulation is derived by.

    Raises:
        ConfigError: one line, where nothing in the tests feels a nuisance that the laboratory told,
            or it tells a number by its key that is fitted anyway.
    """
    applied, tests = measurement.applied(config), measurement.tests
    keys_of = dict.fromkeys(parameter.key for each in applied for parameter in every(each))
    coupons = any(each.experiment == "coupon" for each in tests)
    numbers = {each.told: fitted_in(each, measurement, config) for each in fitted_effects()}
    felt = {told.key: bool(own) for told, own in numbers.items()}
    felt |= {"coupon_area": coupons, "coupon_slack_mm": coupons}
    usual = [key for key in known() if felt.get(key, True)]
    fitted = {number.key: told for told, own in numbers.items() for _, number in own}
    for each in tests:
        for key in sorted(each.setup.told & fitted.keys()):
            raise ConfigError(
                f"[nuisance] {key} = {each.setup.nuisances[key]:g}: every hypothesis fits it; "
                f"allowed: {fitted[key].key}, {fitted[key].words}"
            )
        for key in sorted(each.setup.told - {*usual, *keys_of}):
            allowed = ", ".join([*usual, *(sorted(keys_of) if "." in key else ())])
            raise ConfigError(
                f"[nuisance] {key} = {each.setup.nuisances[key]:g}: nothing in these tests feels "
                f"it; allowed: {allowed}"
            )
    found = [key for each in applied for key in modulus_keys(each)]
    return tuple(dict.fromkeys([*found, *fitted, *_own(measurement)]))


def _own(measurement: Measurement) -> tuple[str, ...]:
    """Keys of the configuration that the laboratory gave a standard deviation."""
    told = [key for test in measurement.tests for key in test.setup.nuisances]
    return tuple(dict.fromkeys(key for key in told if key not in known()))


def nuisances(measurement: Measurement, base: SimulatedReadings) -> list[Nuisance]:
    """All nuisances that change any reading.

    Args:
        measurement: with the laboratory's standard deviations.
        base: simulated with the gradients :func:`keys`.
    """
    listed = measurement.listed
    test = listed["test"].to_numpy()
    configs = {number: run.config for run in base.runs for number in run.group.tests}
    forces, fitted = in_proportion(measurement), fitted_effects()

    def of(key: str, own: np.ndarray | bool = True, name: str = "") -> Nuisance:
        """By the key that is told; of the readings, (n,), that ``own`` marks."""
        change = np.zeros(len(test))
        for each in measurement.tests:
            mine = (test == each.number) & own
            std = each.setup.nuisances.get(key, 0.0)
            for parameter, amount in changes(configs[each.number], key, std).items():
                slope = base.slopes.get(parameter)
                if slope is not None:
                    change[mine] += slope[mine] * amount
        return told(key, change, name)

    def told(key: str, change: np.ndarray, name: str = "") -> Nuisance:
        std = max(each.setup.nuisances.get(key, 0.0) for each in measurement.tests)
        unit = named(key).unit if "." in key else units.unit(key)
        return Nuisance(Unknown.marginal(name or key, std, unit), change)

    area = np.array([each.setup.nuisances["coupon_area"] for each in measurement.tests])
    found = [
        *map(of, (MODULUS, *(each.told.key for each in fitted if not each.told.each_time))),
        told("coupon_area", np.where(forces, base.readings, 0.0) * area[test]),
        *map(of, _own(measurement)),
    ]
    found += [
        of(each.told.key, np.isin(test, numbers), name)
        for each in fitted if each.told.each_time
        for name, numbers in _each_time(each, measurement, configs).items()
    ]  # fmt: skip
    names = list(dict.fromkeys(each.specimen for each in measurement.tests))
    if len(names) > 1:
        specimen = listed["specimen"].to_numpy()
        found += [of(SPECIMEN, specimen == name, f"{SPECIMEN} of {name}") for name in names]
    return [nuisance for nuisance in found if np.nan_to_num(nuisance.change).any()]


def _each_time(
    each: type[Effect], measurement: Measurement, configs: dict[int, Config]
) -> dict[str, list[int]]:
    """Tests by each time that a rig was set up: each file, and each value in it."""
    times: dict[tuple[str, float], list[int]] = {}
    for test in measurement.tests:
        number = each.fitted(configs[test.number]) if feels(each, test) else None
        if number is not None:
            times.setdefault((test.file.name, number.value), []).append(test.number)
    key = each.told.key
    if len(times) == 1:
        return {key: next(iter(times.values()))}
    unit = units.unit(key)
    return {f"{key} at {value:g} {unit} in {file}": own for (file, value), own in times.items()}
