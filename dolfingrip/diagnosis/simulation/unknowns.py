"""Causes that may be named: of the catalogue, and nuisances far from what the laboratory told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.diagnosis.core.unknown import Cause, Unknown, causes, tail_of
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.extensions.effect import Prior
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import every
from dolfingrip.parameter.nuisances import GAP, WALL, modulus_keys, wall_key
from dolfingrip.parameter.nuisances import WALLS as WALL_KEYS
from dolfingrip.sections.section import Role

RIG: Final = {
    "pressure_gain": ("extensions.pressure_gain.gain", "pressure_gain", 1.0),
    "pressure_offset": ("extensions.pressure_offset.offset_kPa", "pressure_offset_kPa", 0.0),
}
"""Numbers of the regulator: key of the configuration, what the laboratory tells, and the middle."""

BODY: Final = {"wall_offset": WALL, "plate_gap": "plate_gap_mm"}
"""Numbers that simulations are made at: what the laboratory tells, by the name of the effect."""

WALLS: Final = "wall_offset"

TILTED: Final = "gravity_pitch"
"""The effect that turns the gravity that a test has."""


def unknowns(
    measurement: Measurement, config: Config, names: Sequence[str] | None = None
) -> list[Cause]:
    """The effects of the catalogue that may be named.

    Args:
        measurement: whose set-ups tell what is there already.
        config: the model that is diagnosed.
        names: of the causes that are tried; everything where None.

    Raises:
        ConfigError: one line with the name of a number of a finger's rig, and the readings that
            feel it, where no reading is of such a rig.
    """
    for name in names or ():
        if name in {*RIG, *BODY} and not _tests_of(name, measurement):
            which = "a blocked finger" if name == "plate_gap" else "a finger"
            raise ConfigError(f"--effects {name}: allowed: with readings of {which}")
    config = measurement.lab(config)
    found = causes(config, names)
    if not config.gravity.acceleration_m_s2:
        return found
    hangs = all(own.gravity.direction == (0.0, 0.0, 1.0) for own in measurement.applied(config))
    return [
        _tilted(each, config) if each.name == TILTED else each
        for each in found if each.name != TILTED or hangs
    ]  # fmt: skip


def _tilted(cause: Cause, config: Config) -> Cause:
    """The pitch in place of the weight, which is there."""
    prior = effect(TILTED).priors()["pitch_deg"]
    reach = POLICY.reach
    weight, *_ = cause.numbers
    pitch = Unknown(f"extensions.{TILTED}.pitch_deg", prior, -reach, reach, (-180.0, 180.0),
                    tail=tail_of(prior))  # fmt: skip
    return Cause(cause.name, (pitch,), ((weight, config.gravity.acceleration_m_s2),))


def _tests_of(name: str, measurement: Measurement) -> list[SpecimenTest]:
    """Tests whose rig has a number: the plate's gap is one of blocked fingers alone."""
    return [
        test
        for test in measurement.tests
        if test.of_finger and (name != "plate_gap" or test.experiment == "blocked_force")
    ]


def rig_numbers(
    measurement: Measurement, config: Config, names: Sequence[str] | None = None
) -> tuple[list[Unknown], list[Unknown]]:
    """Numbers of body and rig that every hypothesis fits, beside the moduli.

    Args:
        measurement: whose set-ups tell them.
        config: the model that is diagnosed.
        names: of the causes that are tried: others are never far off; everything where None.

    Returns:
        Those that simulations are made at, and those that readings are linear in.
    """
    applied = measurement.applied(config)
    bodies = [own for test, own in zip(measurement.tests, applied, strict=True) if test.of_finger]
    on = {each.name() for each in measurement.lab(config).extensions.active()}
    solid: list[Unknown] = []

    def told(name: str, key: str) -> float:
        tests = _tests_of(name, measurement)
        return max((test.setup.nuisances[key] for test in tests), default=0.0)

    def number(name: str, key: str, prior: Prior, bounds: tuple[float, float], tail: float) -> None:
        # walls are fitted, whichever causes are tried
        tried = names is None or name in (*names, WALLS)
        named = (name,) if tried and name not in on else ()
        reach = POLICY.reach * (tail if named else 1.0)
        made = Unknown(key, prior, -reach, reach, bounds, role="always", names=named)
        solid.append(made.reaching(reach))

    walls = {(wall_key(own), own.geometry.wall_mm) for own in bodies if wall_key(own)}
    if len(walls) == 1 and (std := told(WALLS, WALL)):
        ((key, wall_mm),) = walls
        prior = Prior(wall_mm, wall_mm * std, "as reported")
        number(
            WALLS, str(key), prior, (0.2 * wall_mm, 2 * wall_mm), POLICY.walls_reach / POLICY.reach
        )
    gaps = {
        own.plate.gap_mm
        for test, own in zip(measurement.tests, applied, strict=True)
        if test.experiment == "blocked_force"
    }
    if len(gaps) == 1 and (std := told("plate_gap", "plate_gap_mm")):
        prior = Prior(gaps.pop(), std, "as reported")
        number("plate_gap", GAP, prior, (0.0, np.inf), POLICY.implausible_width)
    solid += _own(measurement, config)
    linear = []
    for name, (key, in_setup, middle) in RIG.items():
        if (std := told(name, in_setup)) and name not in on:
            prior, reach = (
                Prior(middle, std, "as reported"),
                POLICY.reach * POLICY.implausible_width,
            )
            named = (name,) if names is None or name in names else ()
            made = Unknown(key, prior, -reach, reach, role="always", names=named)
            linear.append(made)
    return solid, linear


def _own(measurement: Measurement, config: Config) -> list[Unknown]:
    """The body's numbers that the laboratory told a deviation of by their keys."""
    applied = measurement.applied(config)
    bodies = [own for test, own in zip(measurement.tests, applied, strict=True) if test.of_finger]
    told: dict[str, float] = {}
    for test in measurement.tests:
        told |= {key: test.setup.nuisances[key] for key in test.setup.told if "." in key}
    found = []
    for key, std in told.items():
        values = [
            {p.key: (p.value(own), p) for p in every(own) if p.section.role is Role.BODY}.get(key)
            for own in bodies
        ]
        if not bodies or None in values or len({each[0] for each in values if each}) != 1:
            continue
        assert values[0] is not None
        value, parameter = values[0]
        reach = POLICY.walls_reach
        number = Unknown(
            key, Prior(value, std, "as reported"), -reach, reach, (parameter.low, parameter.high),
            role="always", modulus=key in modulus_keys(bodies[0]),
        )  # fmt: skip
        found.append(_feasible(bodies[0], number.reaching(reach)))
    return found


def _feasible(config: Config, number: Unknown) -> Unknown:
    """Return a number within those that a body can be built of."""
    ends = []
    for sign, most in ((-1.0, -number.low), (1.0, number.high)):
        end = 0.0
        while end < most:
            try:
                changed(config, number.change(float(number.at(sign * (end + POLICY.read_beyond)))))
            except ConfigError:
                break
            end += POLICY.read_beyond
        ends.append(sign * end)
    low, high = ends
    return replace(number, low=low, high=high)


def told_as(number: Unknown) -> str:
    """Return the key of ``[nuisance]`` by which a laboratory tells a number.

    Args:
        number: that every hypothesis fits.
    """
    by_key = {key: told for key, told, _ in RIG.values()} | {GAP: BODY["plate_gap"]}
    if number.key in WALL_KEYS:
        return WALL
    return by_key.get(number.key, number.key)
