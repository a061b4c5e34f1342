"""Causes that may be named: of the catalogue, and nuisances far from what the laboratory told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.diagnosis.core.unknown import Cause, Unknown, causes
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.nuisances import feels, fitted_in, told_of
from dolfingrip.extensions.effect import Prior, Stage
from dolfingrip.extensions.index import camera_errors, effect, fitted_effects
from dolfingrip.parameter import every
from dolfingrip.parameter.nuisances import modulus_keys
from dolfingrip.sections.section import Entry, Role

STEP: Final = 0.1
"""Of ζ, by which the range is searched that a body can be built in."""


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
            feel it, where no reading is of such a rig; or with that of an error of a camera that no
            set-up tells, or of a sensor in the place of a camera; or with that of an effect that
            the body cannot have.
    """
    for cls in fitted_effects():
        asked_for = cls.name() in (names or ())
        if asked_for and not any(feels(cls, test) for test in measurement.tests):
            which = "a blocked finger" if cls.felt_by == ("plate",) else "a finger"
            raise ConfigError(f"--effects {cls.name()}: allowed: with readings of {which}")
    applied, cameras = measurement.applied(config), _camera_errors(measurement)
    fingers = [test for test in measurement.tests if test.of_finger]
    replaced = {
        name for name_of, stds in cameras.items() if stds for name in effect(name_of).replaces
        if fingers and all(told_of(effect(name_of), test) for test in fingers)
    }  # fmt: skip
    for name in names or ():
        if name in replaced:
            of_camera = ", ".join(cls for cls in cameras if name in effect(cls).replaces)
            raise ConfigError(f"--effects {name}: allowed: {of_camera}, as a camera shows it")
        if name in cameras and not cameras[name]:
            keys = ", ".join({report.key: 0 for report in effect(name).told_by.values()})
            raise ConfigError(f"--effects {name}: allowed: with [nuisance] {keys} in a set-up")
    every_cause = [
        _implausible(cause, cameras[cause.name], measurement.policy.reach)
        if cause.name in cameras else cause
        for cause in causes(measurement.lab(config), names, measurement.policy)
        if cause.name not in replaced and cameras.get(cause.name, True)
    ]  # fmt: skip
    moving = {"dynamic": any(one.experiment.dynamic for one in applied)}
    there = [one.changed(experiment=moving) for one in applied]
    possible = [c for c in every_cause if all(map(effect(c.name).possible, there))]
    impossible = {c.name for c in every_cause} - {c.name for c in possible}
    for name in names or ():
        if name in impossible:
            raise ConfigError(f"--effects {name}: allowed: with a body and a rig that can have it")
    return possible


def _camera_errors(measurement: Measurement) -> dict[str, dict[str, float]]:
    """Standard deviations of cameras' errors as told, by the effect and the key of each number."""
    stds: dict[str, dict[str, float]] = {cls.name(): {} for cls in camera_errors()}
    for test in measurement.tests:
        for name, by_key in stds.items():
            for key, std in told_of(effect(name), test).items():
                by_key[key] = max(std, by_key.get(key, 0.0))
    return stds


def _implausible(cause: Cause, stds: Mapping[str, float], reach: float) -> Cause:
    """Return a cause of numbers that are integrated out, where they are far from what was told."""
    numbers, held = [], list(cause.held)
    for number in cause.numbers:
        std = stds.get(number.key.rpartition(".")[2])
        if std is None:
            held.append((number, cause.neutral(number)))
            continue
        start = cause.neutral(number)
        ordinary = replace(number, prior=replace(number.prior, mean=start, spread=std))
        numbers.append(ordinary.implausible().reaching(reach))
    return replace(cause, numbers=tuple(numbers), held=tuple(held))


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
    on, policy = measurement.lab(config).extensions.inner, measurement.policy
    solid: list[Unknown] = []
    linear: list[Unknown] = []
    for cls in fitted_effects():
        name, stage, report = cls.name(), issubclass(cls, Stage), cls.told
        felt = fitted_in(cls, measurement, config)
        std = max((test.setup.nuisances[report.key] for test, _ in felt), default=0.0)
        if not std or len({number for _, number in felt}) > 1 or (stage and name in on):
            continue
        number = felt[0][1]
        prior = Prior(number.value, report.spread(std, number.value), "as reported")
        # a shape is fitted, whichever causes are tried
        shape = cls.entry_of(number.key) is Entry.SHAPE
        tried = names is None or name in names or shape
        reach = policy.shape_reach if shape else policy.reach * prior.tail
        made = Unknown(
            number.key, prior, -reach, reach, (number.low, number.high), role="always",
            names=(name,) if tried and name not in on else (), told=report.key,
        )  # fmt: skip
        (linear if stage else solid).append(made.reaching(reach))
    return [*solid, *_own(measurement, config)], linear


def _own(measurement: Measurement, config: Config) -> list[Unknown]:
    """The body's numbers that the laboratory told a deviation of by their keys."""
    applied = measurement.applied(config)
    bodies = [b for test, b in zip(measurement.tests, applied, strict=True) if test.of_finger]
    stds: dict[str, float] = {}
    for test in measurement.tests:
        stds |= {key: test.setup.nuisances[key] for key in test.setup.told if "." in key}
    numbers = []
    for key, std in stds.items():
        values = [
            {p.key: (p.value(b), p) for p in every(b) if p.section.role is Role.BODY}.get(key)
            for b in bodies
        ]
        if not bodies or None in values or len({pair[0] for pair in values if pair}) != 1:
            continue
        assert values[0] is not None
        value, parameter = values[0]
        reach = measurement.policy.shape_reach
        number = Unknown(
            key, Prior(value, std, "as reported"), -reach, reach, (parameter.low, parameter.high),
            role="always", modulus=key in modulus_keys(bodies[0]),
        )  # fmt: skip
        numbers.append(_feasible(bodies[0], number.reaching(reach)))
    return numbers


def _feasible(config: Config, number: Unknown) -> Unknown:
    """Return a number within those that a body can be built of."""
    ends = []
    for sign, most in ((-1.0, -number.low), (1.0, number.high)):
        end = 0.0
        while end < most:
            try:
                changed(config, number.change(float(number.at(sign * (end + STEP)))))
            except ConfigError:
                break
            end = min(end + STEP, most)
        ends.append(sign * end)
    low, high = ends
    return replace(number, low=low, high=high)
