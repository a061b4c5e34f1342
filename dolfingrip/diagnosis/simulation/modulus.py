"""A change of all moduli by one factor, exactly and without a new simulation.

Without weight and without time, equilibrium depends on pressure by modulus alone:

    α(p; cμ) = α(p/c; μ),    F(p; cμ) = c F(p/c; μ),    coupon: F(u; cμ) = c F(u; μ)

where the contacts' stiffness, an energy per volume, too, is c times as large. A change of ±20 %
taken as linear leaves 1.6 standard deviations unexplained, this none.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip import parameter
from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.groups import path_independent
from dolfingrip.diagnosis.simulation.simulated import Simulated

MOST_BEYOND: Final = 10.0
"""Part of the range of a path that ended early, by which its straight line is followed."""


def scales(config: Config) -> bool:
    """Whether the scaling is exact: no weight, no memory, no clock, no modulus of an effect's own.

    Beside effects in general it is not: their parameters are moduli, compliances or offsets.
    Those that are at their neutral values do not matter.
    """
    if config.gravity.acceleration_m_s2 or not path_independent(config):
        return False
    return all(_is_neutral(effect) for effect in config.extensions.active())


def _is_neutral(effect: object) -> bool:
    neutral = getattr(effect, "neutral", {})
    return all(getattr(effect, key) == value for key, value in neutral.items())


def overrides(config: Config, factor: float) -> tuple[str, ...]:
    """What makes all moduli of ``config`` ``factor`` times as large, as with ``--set``."""
    return (
        *parameter.scaled(config, factor),
        f"contact.stiffness_MPa={config.contact.stiffness_MPa * factor!r}",
        f"plate.stiffness_MPa={config.plate.stiffness_MPa * factor!r}",
    )


def scaled(measurement: Measurement, base: Simulated, factor: float) -> np.ndarray:
    """(n,) readings of ``base`` with all moduli ``factor`` times as large.

    Args:
        measurement: that ``base`` was simulated for.
        base: with headroom, or ``factor`` at least 1; each of its configurations
            has to fulfil :func:`scales`.
        factor: above 0. Pressures beyond the headroom, or beyond the last that the base reached,
            are extrapolated along a straight line.

    Raises:
        ValueError: where the scaling is not exact.
    """
    listed = measurement.listed()
    place, column, test = (listed[name].to_numpy() for name in ("row", "column", "test"))
    found = np.full(len(listed), np.nan)
    for run in base.runs:
        if not scales(run.config):
            raise ValueError("moduli do not scale beside gravity or effects")
        (leg,) = run.route.legs
        by = 1.0 if run.group.experiment == "coupon" else 1 / factor
        mine = np.isin(test, run.group.tests)
        for name in set(column[mine]):
            at = np.flatnonzero(mine & (column == name))
            values = run.result.columns.get(str(name), np.empty(0))
            rows = np.full(len(measurement.readings), np.nan)
            # a softer model may end before a reading that the base reaches
            rows[leg.rows] = leg.read(values, leg.rows_at * by, MOST_BEYOND)
            found[at] = rows[place[at]] * (factor if CHANNELS[name].in_proportion else 1.0)
    return found
