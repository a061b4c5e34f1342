"""Causes that may be named: of the catalogue, and nuisances far from what the laboratory told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.core.unknown import Cause, Unknown, causes, tail_of
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import bounds_of
from dolfingrip.parameter.nuisances import WALL

IMPLAUSIBLE: Final = {
    "pressure_gain": ("gain", "pressure_gain", 1.0),
    "pressure_offset": ("offset_kPa", "pressure_offset_kPa", 0.0),
    "plate_gap": ("offset_mm", "plate_gap_mm", 0.0),
    "wall_offset": ("offset_mm", WALL, 0.0),
}
"""Nuisances that can be causes: key of the effect, of what the laboratory tells, and its middle."""

WALLS: Final = "wall_offset"

TILTED: Final = "gravity_pitch"
"""The effect that turns the gravity that a test has."""


def unknowns(
    measurement: Measurement, config: Config, names: Sequence[str] | None = None
) -> list[Cause]:
    """All that may be named: of the catalogue, and of the nuisances where all are tried.

    Args:
        measurement: whose set-ups tell the nuisances.
        config: the model that is diagnosed.
        names: of the causes that are tried; everything where None.

    Raises:
        ConfigError: one line with the name of a number of a finger's rig, and the readings that
            feel it, where no reading is of such a rig.
    """
    for name in names or ():
        if name in IMPLAUSIBLE and not _tests_of(name, measurement):
            which = "a blocked finger" if name == "plate_gap" else "a finger"
            raise ConfigError(f"--effects {name}: allowed: with readings of {which}")
    config = measurement.lab(config)
    found = [
        _tilted(each) if each.name == TILTED and config.gravity.acceleration_m_s2 else each
        for each in causes(config, names)
    ]
    implausible = _implausible(measurement, config)
    return [*found, *(each for each in implausible if names is None or each.name in names)]


def _tilted(cause: Cause) -> Cause:
    """The pitch in place of the weight, which is there."""
    prior = effect(TILTED).priors()["pitch_deg"]
    key = f"extensions.{TILTED}.pitch_deg"
    reach = POLICY.finger_reach
    return Cause(
        cause.name, (Unknown(key, prior, -reach, reach, (-180.0, 180.0), tail=tail_of(prior)),), ()
    )


def _tests_of(name: str, measurement: Measurement) -> list[SpecimenTest]:
    """Tests whose rig has a number: the plate's gap is one of blocked fingers alone."""
    return [
        test
        for test in measurement.tests
        if test.of_finger and (name != "plate_gap" or test.experiment == "blocked_force")
    ]


def _implausible(measurement: Measurement, config: Config) -> list[Cause]:
    on = {each.name() for each in config.extensions.active()}
    fingers = [test for test in measurement.tests if test.of_finger]
    found = []
    for name, (key, told, middle) in IMPLAUSIBLE.items():
        if name in on or not _tests_of(name, measurement):
            continue
        if name == "wall_offset" and config.mesh.file is not None:
            continue
        std = max(test.setup.nuisances[told] for test in fingers)
        if name == "wall_offset":
            std *= config.geometry.wall_mm
        if not std:
            continue
        reach = POLICY.finger_reach
        number = Unknown(
            f"extensions.{name}.{key}", Prior(middle, std, "as reported"), -reach, reach,
            bounds_of(effect(name), key), role="marginal",
        )  # fmt: skip
        cause = number.implausible(name)
        if name == "plate_gap":
            gaps = [t.applied(config).plate.gap_mm for t in fingers]
            (number,) = cause.numbers
            nearest = replace(number, low=max(-reach, number.zeta(-min(gaps))))
            cause = replace(cause, numbers=(nearest,))
        found.append(cause)
    return found
