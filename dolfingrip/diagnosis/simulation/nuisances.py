"""Nuisances: numbers that a laboratory never knows exactly, and no diagnosis names as a cause.

Each is a change of all readings at one standard deviation. They come from the forward
sensitivities of one base simulation; the numbers are those of
:func:`dolfingrip.parameter.nuisances.known`, or the laboratory's own, in the table
``[nuisance]`` of its TOML. There it can give any parameter of the configuration one, too. A
modulus that is far off is not linear: see :mod:`dolfingrip.diagnosis.simulation.simulated`. What a
camera's errors change follows from the simulated readings.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from dolfingrip.channels import TIME
from dolfingrip.config import Change, Config, ConfigError, changed
from dolfingrip.diagnosis.core.unknown import MODULUS, Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, Rows, SpecimenTest, in_proportion
from dolfingrip.diagnosis.simulation.simulated import SimulatedReadings, supplied
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.extensions.effect import Effect, FittedKey
from dolfingrip.extensions.index import camera_errors, fitted_effects
from dolfingrip.parameter import every, named
from dolfingrip.parameter.nuisances import SPECIMEN, changes, known, modulus_keys
from dolfingrip.sections import units


def feels(cls: type[Effect], test: SpecimenTest) -> bool:
    """Tell whether a test is of a finger whose rig feels an effect.

    Args:
        cls: the effect.
        test: one of a measurement.
    """
    acts = supplied(cls, "volume" if test.by_volume else "pressure")
    return test.of_finger and acts and cls.felt_on(EXPERIMENTS[test.experiment].parts)


def fitted_in(
    cls: type[Effect], measurement: Measurement, config: Config
) -> list[tuple[SpecimenTest, FittedKey]]:
    """List the tests that feel an effect, with the number by which each fits it.

    Args:
        cls: an effect that every hypothesis fits.
        measurement: with the tests.
        config: the model that is diagnosed.
    """
    every_test = zip(measurement.tests, measurement.applied(config), strict=True)
    numbers = [(test, cls.fitted(applied)) for test, applied in every_test if feels(cls, test)]
    return [(test, number) for test, number in numbers if number is not None]


def keys(measurement: Measurement, config: Config) -> tuple[str, ...]:
    """Parameters that a base simulation is derived by.

    Raises:
        ConfigError: one line, where nothing in the tests feels a nuisance that the laboratory told,
            or it tells a number by its key that is fitted anyway.
    """
    applied, tests = measurement.applied(config), measurement.tests
    keys_of = dict.fromkeys(parameter.key for one in applied for parameter in every(one))
    coupons = any(test.experiment == "coupon" for test in tests)
    numbers = {cls.told: fitted_in(cls, measurement, config) for cls in fitted_effects()}
    felt = {report.key: bool(pairs) for report, pairs in numbers.items()}
    felt |= {"coupon_area": coupons, "coupon_slack_mm": coupons}
    seen = any(test.of_finger for test in tests)
    felt |= {report.key: seen for cls in camera_errors() for report in cls.told_by.values()}
    usual = [key for key in known() if felt.get(key, True)]
    fitted = {number.key: report for report, pairs in numbers.items() for _, number in pairs}
    for test in tests:
        for key in sorted(test.setup.told & fitted.keys()):
            raise ConfigError(
                f"[nuisance] {key} = {test.setup.nuisances[key]:g}: every hypothesis fits it; "
                f"allowed: {fitted[key].key}, {fitted[key].words}"
            )
        for key in sorted(test.setup.told - {*usual, *keys_of}):
            allowed = ", ".join([*usual, *(sorted(keys_of) if "." in key else ())])
            raise ConfigError(
                f"[nuisance] {key} = {test.setup.nuisances[key]:g}: nothing in these tests feels "
                f"it; allowed: {allowed}"
            )
    moduli = [key for one in applied for key in modulus_keys(one)]
    return tuple(dict.fromkeys([*moduli, *fitted, *_own(measurement)]))


def _own(measurement: Measurement) -> tuple[str, ...]:
    """Keys of the configuration that the laboratory gave a standard deviation."""
    listed = [key for test in measurement.tests for key in test.setup.nuisances]
    return tuple(dict.fromkeys(key for key in listed if key not in known()))


def nuisances(measurement: Measurement, base: SimulatedReadings) -> list[Nuisance]:
    """All nuisances that change any reading.

    Args:
        measurement: with the laboratory's standard deviations.
        base: simulated with the gradients :func:`keys`.
    """
    listed = measurement.listed
    test = listed["test"].to_numpy()
    configs = _configs(base)
    forces, fitted = in_proportion(measurement), fitted_effects()

    def of(key: str, marked: np.ndarray | bool = True, name: str = "") -> Nuisance:
        """By the key that is told; of the readings, (n,), that are ``marked``."""
        stds = np.array([t.setup.nuisances.get(key, 0.0) for t in measurement.tests])
        by_one = base.changes(lambda config: changes(config, key, 1.0))
        change = marked * stds[test] * np.nan_to_num(measurement.collected(by_one))
        return told(key, change, name)

    def told(key: str, change: np.ndarray, name: str = "") -> Nuisance:
        std = max(t.setup.nuisances.get(key, 0.0) for t in measurement.tests)
        unit = named(key).unit if "." in key else units.unit(key)
        values = (p.value(one) for one in configs.values() for p in every(one) if p.key == key)
        return Nuisance(Unknown.marginal(name or key, std, unit, next(values, 0.0)), change)

    area = np.array([t.setup.nuisances["coupon_area"] for t in measurement.tests])
    numbers = [
        *map(of, (MODULUS, *(cls.told.key for cls in fitted if not cls.told.each_time))),
        told("coupon_area", np.where(forces, base.readings, 0.0) * area[test]),
        *map(of, _own(measurement)),
    ]
    numbers += [
        of(cls.told.key, np.isin(test, tests), name)
        for cls in fitted if cls.told.each_time
        for name, tests in _each_time(cls, measurement, configs).items()
    ]  # fmt: skip
    numbers += _of_camera(measurement, base)
    names = list(dict.fromkeys(t.specimen for t in measurement.tests))
    if len(names) > 1:
        specimen = listed["specimen"].to_numpy()
        numbers += [of(SPECIMEN, specimen == name, f"{SPECIMEN} of {name}") for name in names]
    return [nuisance for nuisance in numbers if np.nan_to_num(nuisance.change).any()]


def told_of(cls: type[Effect], test: SpecimenTest) -> Mapping[str, float]:
    """Standard deviations of an effect's numbers that a test's set-up tells, by their keys.

    Args:
        cls: an effect with :attr:`~dolfingrip.extensions.effect.Effect.told_by`.
        test: one of a measurement.
    """
    stds = {
        key: report.spread(test.setup.nuisances[report.key], float(cls.neutral[key]))
        for key, report in cls.told_by.items()
        if test.of_finger
    }
    return {key: std for key, std in stds.items() if std}


def displayed(measurement: Measurement, rows: Rows, configs: Mapping[int, Config]) -> np.ndarray:
    """Readings (n,) as instruments show them.

    Args:
        measurement: with the rows.
        rows: true ones, (rows,) each, by the tests that they are of and by column.
        configs: set-up and errors of the instruments, by the number of each test.
    """
    readings, shown = measurement.readings, dict[tuple[int, ...], dict[str, np.ndarray]]()
    test, time_s = readings["test"].to_numpy(), readings["time_s"].to_numpy()
    for tests, columns in rows.items():
        shown[tests] = {name: np.full(len(readings), np.nan) for name in columns}
        for number in tests:
            mine = test == number
            true = {name: values[mine] for name, values in columns.items()}
            true[TIME.name] = time_s[mine] - time_s[mine][0]
            config = configs[number]
            for name, values in config.extensions.displayed(true, config.camera).items():
                if name in columns:
                    shown[tests][name][mine] = values
    return measurement.collected(shown)


def _configs(base: SimulatedReadings) -> dict[int, Config]:
    """Configuration that each test was simulated with, by its number."""
    return {number: run.config for run in base.runs for number in run.group.tests}


def _of_camera(measurement: Measurement, base: SimulatedReadings) -> Iterator[Nuisance]:
    """Changes of the readings by each number of a camera's errors that a laboratory tells."""
    configs, rows = _configs(base), base.true
    true = displayed(measurement, rows, configs)
    for cls in camera_errors():
        for key, report in cls.told_by.items():
            off, most = dict(configs), 0.0
            for test in measurement.tests:
                if std := told_of(cls, test).get(key, 0.0):
                    error: Change = {**cls.neutral, key: float(cls.neutral[key]) + std}
                    named_so = {f"extensions.{cls.name()}.{k}": v for k, v in error.items()}
                    off[test.number] = changed(configs[test.number], named_so)
                    most = max(most, test.setup.nuisances[report.key])
            if most:
                shown = displayed(measurement, rows, off)
                name = f"{report.key}, {key}"
                unknown = Unknown.marginal(name, most, units.unit(report.key))
                yield Nuisance(unknown, shown - true)


def _each_time(
    cls: type[Effect], measurement: Measurement, configs: dict[int, Config]
) -> dict[str, list[int]]:
    """Tests by each time that a rig was set up: each file, and each value in it."""
    times: dict[tuple[str, float], list[int]] = {}
    for test in measurement.tests:
        number = cls.fitted(configs[test.number]) if feels(cls, test) else None
        if number is not None:
            times.setdefault((test.file.name, number.value), []).append(test.number)
    key = cls.told.key
    if len(times) == 1:
        return {key: next(iter(times.values()))}
    unit = units.unit(key)
    return {f"{key} at {value:g} {unit} in {file}": tests for (file, value), tests in times.items()}
