"""Numbers of finger and rig that can be measured by themselves, without another test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.unknown import MODULUS
from dolfingrip.diagnosis.simulation.nuisances import BASE_LAYER
from dolfingrip.experiments.derivatives.gradients import MASS, shape_number
from dolfingrip.parameter import every
from dolfingrip.parameter.nuisances import GAIN, OFFSET, wall_key

WALL_OFFSET: Final = "extensions.wall_offset.offset_mm"
BASE_OFFSET: Final = "extensions.base_layer_offset.offset_mm"
GAP_OFFSET: Final = "extensions.plate_gap.offset_mm"


@dataclass(frozen=True, slots=True)
class NumberCheck:
    """A measurement of numbers by themselves.

    Attributes:
        name: in words.
        minutes: that it takes, an engineering guess.
        readings: coefficients of the numbers that each reading is the sum of, by key.
        std: standard deviation of each reading, an engineering guess of usual tools.
    """

    name: str
    minutes: float
    readings: tuple[Mapping[str, float], ...]
    std: tuple[float, ...]

    def read(self, values: Mapping[str, float]) -> np.ndarray:
        """Readings, or derivatives of them, from those of the numbers; shape (readings,)."""
        return np.array([
            sum(by * values.get(key, 0.0) for key, by in own.items()) for own in self.readings
        ])  # fmt: skip


def _each(name: str, minutes: float, numbers: Mapping[str, float]) -> NumberCheck:
    """A check that reads each number by itself, each with its standard deviation."""
    return NumberCheck(name, minutes, tuple({key: 1.0} for key in numbers), tuple(numbers.values()))


INSTRUMENTS: Final = (
    _each("a manometer at the finger's inlet, at rest and at the highest pressure", 10.0,
          {GAIN: 0.0025, OFFSET: 0.3}),
    _each("a known weight on the load cell, and none", 5.0,
          {"extensions.force_gain.gain": 0.002, "extensions.force_offset.offset_N": 0.005}),
    _each("a gauge block between finger and plate", 5.0, {GAP_OFFSET: 0.05}),
    _each("a square of known angle in the camera's picture", 5.0,
          {"extensions.angle_gain.gain": 0.003, "extensions.angle_offset.offset_deg": 0.1}),
    _each("the tip's face read beside the markers", 10.0,
          {"extensions.angle_definition.chord_share": 0.02}),
    _each("a spirit level at the clamp, and how the finger hung told under [gravity]", 2.0,
          {"extensions.gravity_pitch.pitch_deg": 0.5,
           "extensions.gravity_pitch.acceleration_m_s2": 0.1}),
    _each("a square between plate and clamp", 5.0, {"extensions.plate_tilt.offset_deg": 0.3}),
    _each("a pressure sensor at the finger beside the regulator's, along a fast ramp", 15.0,
          {"extensions.line_lag.tau_s": 0.02}),
    _each("a camera's angle beside the sensor's, along a fast ramp", 15.0,
          {"extensions.angle_lag.tau_s": 0.02}),
)  # fmt: skip
"""Those that need nothing of the finger's shape."""

CUT_MM: Final = 0.05
"""Standard deviation of callipers at a cut finger."""
MASS_SHARE: Final = 0.01
"""Relative standard deviation of what a mass tells: the print's density is not better known."""
COUPON_SHARE: Final = 0.05
"""Relative standard deviation of a modulus by coupons of another print."""


def checks(config: Config) -> Sequence[NumberCheck]:
    """List what can be measured by itself of a finger and its rig.

    Args:
        config: of the finger, as it was drawn.
    """
    found = [*INSTRUMENTS, _each("a coupon in uniaxial tension", 15.0, {MODULUS: COUPON_SHARE})]
    wall = wall_key(config)
    if wall is None:
        return found
    known = {each.key: each for each in every(config)}
    parameters = [known[key] for key in (wall, BASE_LAYER) if key in known]
    mass_g, by = shape_number(MASS, config, parameters)
    walls, base = {wall: 1.0, WALL_OFFSET: 1.0}, {BASE_OFFSET: 1.0}
    of_mass = {wall: by[wall], WALL_OFFSET: by[wall], BASE_OFFSET: by.get(BASE_LAYER, 0.0)}
    return [
        *found,
        NumberCheck("weigh the finger", 2.0, (of_mass,), (MASS_SHARE * mass_g,)),
        NumberCheck("cut a finger of this print: callipers at walls and base layer", 15.0,
              (walls, base), (CUT_MM, CUT_MM)),
    ]  # fmt: skip
