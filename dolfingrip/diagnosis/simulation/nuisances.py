"""Nuisances: numbers that a laboratory never knows exactly, and no diagnosis names as a cause.

Each is a change of all readings at one standard deviation. They come from the forward
sensitivities of one base simulation; the numbers are those of
:data:`dolfingrip.parameter.nuisances.NUISANCES`, or the laboratory's own, in the table
``[nuisance]`` of its TOML. There it can give any parameter of the configuration one, too. A
modulus that is far off is not linear: see :mod:`dolfingrip.diagnosis.simulation.simulated`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.core.unknown import Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement, in_proportion
from dolfingrip.diagnosis.simulation.simulated import SimulatedReadings
from dolfingrip.parameter import every, named
from dolfingrip.parameter.nuisances import (
    GAIN,
    GAP,
    NUISANCES,
    OFFSET,
    SPECIMEN,
    WALL,
    WALLS,
    changes,
    modulus_keys,
    wall_key,
)

BASE_LAYER: Final = "finger.base_layer_mm"

UNITS: Final = {
    "pressure_offset_kPa": "kPa", "plate_gap_mm": "mm", "coupon_slack_mm": "mm"
}  # fmt: skip
"""Of nuisances that are no parameters and are not relative."""


def keys(measurement: Measurement, config: Config) -> tuple[str, ...]:
    """Parameters that a base simulation is derived by; the base layer's serves an effect.

    Raises:
        ConfigError: one line, where nothing in the tests feels a nuisance that the laboratory told,
            or it tells the walls' thickness by its key, which is fitted anyway.
    """
    applied, tests = measurement.applied(config), measurement.tests
    known = dict.fromkeys(parameter.key for each in applied for parameter in every(each))
    coupons = any(each.experiment == "coupon" for each in tests)
    fingers = any(each.of_finger for each in tests)
    felt = {
        WALL: fingers and any(map(wall_key, applied)),
        "pressure_gain": fingers,
        "pressure_offset_kPa": fingers,
        "plate_gap_mm": any(each.experiment == "blocked_force" for each in tests),
        "coupon_area": coupons,
        "coupon_slack_mm": coupons,
    }
    usual = [key for key in NUISANCES if felt.get(key, True)]
    walls = {wall_key(each) for each in applied}
    for each in tests:
        for key in sorted(each.setup.told & walls):
            raise ConfigError(
                f"[nuisance] {key} = {each.setup.nuisances[key]:g}: walls are fitted in every "
                f"hypothesis; allowed: {WALL}, relative to their thickness"
            )
        for key in sorted(each.setup.told - {*usual, *known}):
            allowed = ", ".join([*usual, *(sorted(known) if "." in key else ())])
            raise ConfigError(
                f"[nuisance] {key} = {each.setup.nuisances[key]:g}: nothing in these tests feels "
                f"it; allowed: {allowed}"
            )
    found = [key for each in applied for key in modulus_keys(each)]
    found += [*WALLS, BASE_LAYER, GAIN, OFFSET, GAP, *_own(measurement)]
    return tuple(dict.fromkeys(found))


def _own(measurement: Measurement) -> tuple[str, ...]:
    """Keys of the configuration that the laboratory gave a standard deviation."""
    told = [key for test in measurement.tests for key in test.setup.nuisances]
    return tuple(dict.fromkeys(key for key in told if key not in NUISANCES))


def nuisances(measurement: Measurement, base: SimulatedReadings) -> list[Nuisance]:
    """All nuisances that change any reading.

    Args:
        measurement: with the laboratory's standard deviations.
        base: simulated with the gradients :func:`keys`.
    """
    listed = measurement.listed
    test = listed["test"].to_numpy()
    configs = {number: run.config for run in base.runs for number in run.group.tests}
    forces = in_proportion(measurement)

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
        unit = UNITS.get(key) or (named(key).unit if "." in key else "")
        return Nuisance(Unknown.marginal(name or key, std, unit), change)

    area = np.array([each.setup.nuisances["coupon_area"] for each in measurement.tests])
    found = [
        *map(of, ("modulus", WALL, "pressure_gain", "pressure_offset_kPa")),
        told("coupon_area", np.where(forces, base.readings, 0.0) * area[test]),
        *map(of, _own(measurement)),
    ]
    found += [
        of("plate_gap_mm", np.isin(test, numbers), name)
        for name, numbers in _plates(measurement, configs).items()
    ]
    names = list(dict.fromkeys(each.specimen for each in measurement.tests))
    if len(names) > 1:
        specimen = listed["specimen"].to_numpy()
        found += [of(SPECIMEN, specimen == name, f"{SPECIMEN} of {name}") for name in names]
    return [nuisance for nuisance in found if np.nan_to_num(nuisance.change).any()]


def _plates(measurement: Measurement, configs: dict[int, Config]) -> dict[str, list[int]]:
    """Tests by each time that the plate was set: each file, and each gap in it."""
    times: dict[tuple[str, float], list[int]] = {}
    for each in measurement.tests:
        if each.experiment == "blocked_force":
            gap_mm = configs[each.number].plate.gap_mm
            times.setdefault((each.file.name, gap_mm), []).append(each.number)
    if len(times) == 1:
        return {"plate_gap_mm": next(iter(times.values()))}
    return {f"plate_gap_mm at {mm:g} mm in {file}": own for (file, mm), own in times.items()}
