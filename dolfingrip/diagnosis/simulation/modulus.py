"""A change of all moduli by one factor, exactly and without a new simulation.

Without weight and without time, equilibrium depends on pressure by modulus alone:

    α(p; cμ) = α(p/c; μ),    F(p; cμ) = c F(p/c; μ),    coupon: F(u; cμ) = c F(u; μ)

where the contacts' stiffness, an energy per volume, too, is c times as large. A change of ±20 %
taken as linear leaves 1.6 standard deviations unexplained, this none.
"""

from __future__ import annotations

from collections.abc import Sequence

from dolfingrip import parameter
from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.simulation.groups import path_independent
from dolfingrip.diagnosis.simulation.simulated import SimulatedGroup


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


def scale_all(runs: Sequence[SimulatedGroup]) -> bool:
    """Return whether it is exact for all simulations of a measurement."""
    return all(scales(run.config) for run in runs)


def overrides(config: Config, factor: float) -> Change:
    """Return the change that makes all moduli ``factor`` times as large, contacts' stiffness too.

    Args:
        config: whose moduli they are.
        factor: above 0.
    """
    return {
        **parameter.scaled(config, factor),
        "contact.stiffness_MPa": config.contact.stiffness_MPa * factor,
        "plate.stiffness_MPa": config.plate.stiffness_MPa * factor,
    }
