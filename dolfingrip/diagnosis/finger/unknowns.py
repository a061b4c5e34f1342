"""Causes of fingers: effects of the catalogue, and nuisances far from what the laboratory told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.core.emulator import Coordinate
from dolfingrip.diagnosis.core.unknown import Cause, Unknown, causes, tail_of
from dolfingrip.diagnosis.data.measurement import Measurement, SpecimenTest
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.extensions.effect import Displaying, Prior
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
    measurement: Measurement, config: Config, names: Sequence[str] | None, *, walls: bool = False
) -> list[Cause]:
    """All that may be named: of the catalogue, and of the nuisances where all are tried.

    Args:
        measurement: whose set-ups tell the nuisances.
        config: the model that is diagnosed, with the laboratory's gravity.
        names: of the causes that are tried; everything where None.
        walls: whether these are fitted in every hypothesis, and so no cause beside it.
    """
    found = [
        _tilted(each) if each.name == TILTED and config.gravity.acceleration_m_s2 else each
        for each in causes(config, names)
    ]
    implausible = [
        each for each in _implausible(measurement, config) if not (walls and each.name == WALLS)
    ]
    return [*found, *(each for each in implausible if names is None or each.name in names)]


def _tilted(cause: Cause) -> Cause:
    """The pitch in place of the weight, which is there."""
    prior = effect(TILTED).priors()["pitch_deg"]
    key = f"extensions.{TILTED}.pitch_deg"
    reach = POLICY.finger_reach
    return Cause(
        cause.name, (Unknown(key, prior, -reach, reach, (-180.0, 180.0), tail=tail_of(prior)),), ()
    )


def check_rig(names: Sequence[str] | None, measurement: Measurement) -> None:
    """Refuse numbers of a finger's rig where no reading is of such a rig.

    Args:
        names: of effects; None for the whole catalogue.
        measurement: the readings.

    Raises:
        ConfigError: one line with the name and the readings that feel it.
    """
    for name in names or ():
        if name in IMPLAUSIBLE and not _tests_of(name, measurement):
            which = "a blocked finger" if name == "plate_gap" else "a finger"
            raise ConfigError(f"--effects {name}: allowed: with readings of {which}")


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


def box_of(cause: Cause) -> np.ndarray:
    """Ranges of ζ, as far as a finger is simulated unless readings ask for more, (numbers, 2)."""
    # an instrument needs no simulation
    far = cause.tails if issubclass(effect(cause.name), Displaying) else np.ones(len(cause.numbers))
    reach = POLICY.finger_reach * far[:, None] + POLICY.read_beyond
    return np.clip(cause.box(), -reach, reach)


def wider(cause: Cause, box: np.ndarray, zeta: np.ndarray) -> np.ndarray | None:
    """Ranges as wide as the prior has any weight, where amplitudes lie at an end.

    Args:
        cause: the effect.
        box: ranges of ζ so far, (d, 2).
        zeta: its numbers, (d,).

    Returns:
        The ranges, (d, 2); None where no number lies at an end beyond which its effect is stronger.
    """
    found = box.copy()
    for place, (number, z, ends) in enumerate(zip(cause.numbers, zeta, box, strict=True)):
        far = number.reaching(POLICY.farthest * number.tail)
        for side, (sign, most) in enumerate(((-1.0, far.low), (1.0, far.high))):
            at_end = sign * (z - ends[side]) >= -POLICY.read_beyond
            stronger = sign * (float(number.at(ends[side])) - cause.neutral(number)) > 0
            if number.tail > 1 and at_end and stronger and sign * (most - ends[side]) > 0:
                found[place, side] = most
    return None if np.array_equal(found, box) else found


def coordinates_of(cause: Cause, box: np.ndarray, first: int = 0) -> tuple[Coordinate, ...]:
    """Return the coordinates that a cause's change is a polynomial of.

    Args:
        cause: whose numbers are ζ.
        box: ranges of these, (numbers, 2).
        first: place of the first of them in ζ.
    """
    found: list[Coordinate] = []
    for i, number in enumerate(cause.numbers, first):
        own = replace(_coordinate(cause, number, box[i - first]), of=i)
        found += _sides(own) if effect(cause.name).lopsided and own.amplitude else [own]
    return tuple(found)


def _sides(own: Coordinate) -> list[Coordinate]:
    """An amplitude that changes the readings in different ways to either side."""
    inner = own.value
    return [
        replace(own, value=lambda zeta: np.maximum(inner(zeta), 0.0)),
        replace(own, value=lambda zeta: np.minimum(inner(zeta), 0.0)),
    ]


def _coordinate(cause: Cause, number: Unknown, box: np.ndarray) -> Coordinate:
    if not number.amplitude:
        return Coordinate(lambda zeta: 0.5 * zeta, amplitude=False)
    start, step = cause.start_and_step(number)
    reach = POLICY.finger_reach
    if not number.prior.positive:  # of ordinary size, however far that is
        step *= max(1.0, float(np.abs(box).max()) / (reach + POLICY.read_beyond))

    def value(zeta: np.ndarray) -> np.ndarray:
        return (number.at(zeta) - start) / step

    ends = np.asarray(value(np.array([-reach, reach])))
    return Coordinate(value, amplitude=True, signed=bool(ends.min() < -1e-9))
