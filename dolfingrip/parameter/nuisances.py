"""Nuisances: numbers that nobody knows exactly, and the parameters that change with each.

A standard deviation of one is a change of one or more parameters at once: a material that is 20 %
softer has smaller moduli in every region and film.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from dolfingrip.config import Change, Config
from dolfingrip.parameter.search import find, moduli
from dolfingrip.sections.geometry.index import TABLES

NUISANCES: Final[Mapping[str, tuple[float, str]]] = {
    "modulus": (0.2, "relative, of the material"),
    "wall": (0.05, "relative, of the walls' thickness wall_mm"),
    "pressure_gain": (0.015, "relative, of the regulator's scale"),
    "pressure_offset_kPa": (2.0, "of the regulator's zero"),
    "plate_gap_mm": (0.3, "of the force sensor's place, each time it is set"),
    "specimen_scale": (0.015, "relative, of one specimen's stiffness where there are several"),
    "coupon_area": (0.0, "relative, of the coupons' cross-section"),
    "coupon_slack_mm": (0.1, "of the travel at which the force of each coupon begins"),
    "material_law": (
        0.01,
        "relative, of a coupon's force and width: what no simple law of a material follows",
    ),
}
"""Standard deviations of nuisances, which are no causes, in the key's unit, with explanations."""

USUAL: Final = {key: std for key, (std, _) in NUISANCES.items()}

WALLS: Final = tuple(f"{table}.wall_mm" for table in TABLES)
WALL: Final = "wall"
"""Name of the nuisance that these are."""
GAIN: Final = "extensions.pressure_gain.gain"
OFFSET: Final = "extensions.pressure_offset.offset_kPa"
GAP: Final = "plate.gap_mm"

SPECIMEN: Final = "specimen_scale"
STIFFNESSES: Final = ("modulus", SPECIMEN)
"""Nuisances that are factors of all moduli."""


def neutral_stages(config: Config) -> Change:
    """Return the change that makes the regulator's gain and offset parameters, without effect.

    An effect that is on already stays as it is.

    Args:
        config: of a finger.
    """
    neutral = {"pressure_gain": (GAIN, 1.0), "pressure_offset": (OFFSET, 0.0)}
    return dict(n for name, n in neutral.items() if getattr(config.extensions, name) is None)


def wall_key(config: Config) -> str | None:
    """Return the key of the walls' thickness; None where the body has none, as of a mesh file.

    Args:
        config: of a finger.
    """
    key = f"{config.geometry_table}.wall_mm"
    return key if config.mesh.file is None and key in WALLS else None


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
        nuisance: key of :data:`NUISANCES`, or of a number of the configuration.
        std: standard deviation, in the key's unit.

    Returns:
        Change by the parameter's key, in its unit; empty where no parameter is meant.
    """
    if nuisance in STIFFNESSES:
        return {each.key: std * each.value(config) for each in find(config, modulus_keys(config))}
    if nuisance == WALL:
        wall = wall_key(config)
        return {} if wall is None else {wall: std * config.geometry.wall_mm}
    if nuisance == "pressure_gain":
        on = getattr(config.extensions, "pressure_gain")  # noqa: B009
        return {GAIN: std * (1.0 if on is None else float(on.gain))}
    if nuisance in NUISANCES:
        own_key = {"pressure_offset_kPa": OFFSET, "plate_gap_mm": GAP}.get(nuisance)
        return {} if own_key is None else {own_key: std}
    return {nuisance: std}
