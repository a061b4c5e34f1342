"""Nuisances: numbers that nobody knows exactly, and the parameters that change with each.

A standard deviation of one is a change of one or more parameters at once: a material that is 20 %
softer has smaller moduli in every region and film.
"""

from __future__ import annotations

from typing import Final

from dolfingrip.config import Change, Config
from dolfingrip.extensions.effect import Stage
from dolfingrip.extensions.index import camera_errors, fitted_effects
from dolfingrip.parameter.search import find, moduli

WALL: Final = "wall"
"""Name of the nuisance that the walls' thickness is."""

SPECIMEN: Final = "specimen_scale"
STIFFNESSES: Final = ("modulus", SPECIMEN)
"""Nuisances that are factors of all moduli."""


def known() -> dict[str, tuple[float, str]]:
    """Return standard deviations of nuisances in the key's unit, with explanations."""
    every = [effect.told for effect in fitted_effects()]
    return {
        "modulus": (0.2, "relative, of the material"),
        **{nuisance.key: (nuisance.std, nuisance.words) for nuisance in every},
        SPECIMEN: (0.015, "relative, of one specimen's stiffness where there are several"),
        "coupon_area": (0.0, "relative, of the coupons' cross-section"),
        "coupon_slack_mm": (0.1, "of the travel at which the force of each coupon begins"),
        "material_law": (
            0.01,
            "relative, of a coupon's force and width: what no simple law of a material follows",
        ),
        **{
            report.key: (report.std, report.words)
            for effect in camera_errors()
            for report in effect.told_by.values()
        },
    }


def usual() -> dict[str, float]:
    """Return the standard deviations of nuisances that nobody told, in the key's unit."""
    return {key: std for key, (std, _) in known().items()}


def neutral_stages(config: Config) -> Change:
    """Return the change that makes the regulator's gain and offset parameters, without effect.

    An effect that is on already stays as it is.

    Args:
        config: of a finger.
    """
    on = config.extensions.inner
    stages = [e for e in fitted_effects() if issubclass(e, Stage) and e.name() not in on]
    return {number.key: number.value for e in stages if (number := e.fitted(config))}


def modulus_keys(config: Config) -> tuple[str, ...]:
    """Return the keys of all moduli that grow with the material's stiffness.

    Args:
        config: of the specimen.
    """
    return tuple(key for key in moduli(config) if not key.endswith("bulk_MPa"))


def changes(config: Config, nuisance: str, std: float) -> dict[str, float]:
    """Return the changes of parameters at a standard deviation of a nuisance.

    Args:
        config: of the specimen.
        nuisance: one of :func:`known`, or a number of the configuration by its key.
        std: standard deviation, in the key's unit.

    Returns:
        Change by the parameter's key, in its unit; empty where no parameter is meant.
    """
    if nuisance in STIFFNESSES:
        return {p.key: std * p.value(config) for p in find(config, modulus_keys(config))}
    for effect in fitted_effects():
        if effect.told.key == nuisance:
            number = effect.fitted(config)
            return {number.key: effect.told.spread(std, number.value)} if number else {}
    return {} if nuisance in known() else {nuisance: std}
