"""Doubts about a finger's result: what its motion, its walls and its mesh make uncertain."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from dolfingrip.channels import (
    ANGLE,
    BENDING_ANGLE,
    BENDING_DIRECTION,
    BREAK_SHARE,
    LARGEST_STRETCH,
    PRESSURE,
    WALL_GAP,
)
from dolfingrip.sections.material import DEFAULT, OF_RUBBER, known_as

if TYPE_CHECKING:
    from dolfingrip.config import Config
    from dolfingrip.experiments.results.readings import Readings


LEAST_DEG: Final = 0.05
"""Bending whose direction is no rounding, and which is looked at."""

SIDEWAYS: Final = 0.1
"""Part of the bending out of the plane that the angle is read in."""

BACKWARDS_DEG: Final = 0.5
"""Negative angle of a finger that is meant to bend forwards."""

SINGLE: Final = 0.5
"""Part of the cells on a cavity that lie on the skin, too."""


class Doubt(NamedTuple):
    """One doubt: what is doubted, and the sentence."""

    title: str
    sentence: str


def of_motion(result: Readings) -> Iterator[Doubt]:
    """Yield the doubts that follow from the readings of one finger.

    Args:
        result: readings with their configuration.
    """
    if not result.rows or BENDING_ANGLE.name not in result:
        return
    size, direction, angle, pressure = (
        result.column(c.name) for c in (BENDING_ANGLE, BENDING_DIRECTION, ANGLE, PRESSURE)
    )
    off = np.nan_to_num(np.abs(np.sin(np.radians(direction))))
    most = int(np.argmax(size * off))
    if size[most] > LEAST_DEG and off[most] > SIDEWAYS:
        yield Doubt(
            "plane of bending",
            f"at {pressure[most]:g} kPa the finger bends by {size[most]:.3g}° in the direction of "
            f"{direction[most]:.0f}°, out of the plane that angle_deg is read in; take "
            "bending_angle_deg and bending_direction_deg",
        )
    if BREAK_SHARE.name in result:
        share = result.column(BREAK_SHARE.name)
        first = int(np.argmax(share >= 1))
        if share[first] >= 1:
            before = max(first - 1, 0)
            reached = np.interp(1.0, share[[before, first]], pressure[[before, first]])
            yield Doubt(
                "elongation at break",
                f"a wall breaks at {reached:.3g} kPa: its elongation reaches that at break",
            )
    if LARGEST_STRETCH.name in result:
        stretch = float(np.nanmax(result.column(LARGEST_STRETCH.name)))
        yield from (Doubt("the law's stretch", line) for line in of_law(result.config, stretch))
    ratios = [cavity.pressure_ratio for cavity in result.config.cavity.all.values()]
    highest = int(np.argmax(pressure))
    forwards = pressure[highest] > 0 and all(ratio == 1 for ratio in ratios)
    if forwards and angle[highest] < -BACKWARDS_DEG:
        yield Doubt(
            "direction of bending",
            f"at {pressure[highest]:g} kPa the angle is {angle[highest]:.1f}°: the finger bends "
            "away from its back; see whether the back, at the lowest x, is the right side",
        )
    if WALL_GAP.name in result:
        gap = result.column(WALL_GAP.name)
        touch = np.flatnonzero(gap < result.config.contact.barrier_mm)
        if touch.size:
            first = int(touch[0])
            yield Doubt(
                "walls inside",
                f"walls of a cavity touch one another from {pressure[first]:g} kPa on",
            )


def elongation(result: Readings) -> list[str]:
    """Say how near the material is to its elongation at break; nothing where that is not told.

    Args:
        result: readings with their configuration.
    """
    if BREAK_SHARE.name not in result:
        return []
    share, pressure = result.column(BREAK_SHARE.name), result.column(PRESSURE.name)
    most = int(np.argmax(share))
    return [
        f"largest elongation: {100 * share[most]:.3g} % of that at break, at {pressure[most]:g} kPa"
    ]


def not_given(config: Config) -> list[str]:
    """Say which numbers of a material nobody gave, and what stands in their place.

    Args:
        config: of a run; the default material is known as a whole.
    """
    material, default = config.material, DEFAULT
    if material.constants() == default.constants():
        return []
    missing = [] if material.nu or material.bulk_MPa else [f"nu = {material.poisson:g}"]
    if config.gravity.acceleration_m_s2 and material.density_kg_m3 == default.density_kg_m3:
        missing.append(f"density_kg_m3 = {default.density_kg_m3:g}")
    what = f"not given, so printed NinjaFlex's is taken; rubber has nu = {OF_RUBBER}"
    return [f"material: {' and '.join(missing)}: {what}"] if missing else []


def of_law(config: Config, stretch: float) -> list[str]:
    """Say where a run leaves the stretches that a named material's law is known of.

    Args:
        config: of the run.
        stretch: the largest one.
    """
    name, limit = known_as(config.material) or ("", {"stretch": np.inf})
    if stretch <= 1.001 * limit["stretch"]:
        return []
    return [
        f"{name}: the largest stretch is {stretch:.3g}; its law is known to {limit['stretch']:g} "
        f"alone ({limit['source']})"
    ]


def of_run(result: Readings, single: float) -> Iterator[Doubt]:
    """Yield the doubts about a finger's run: of its motion, and of its mesh.

    Args:
        result: readings with their configuration.
        single: part of the elements on a cavity that lie on the skin, too.
    """
    yield from of_motion(result)
    if result.config.solver.element == "P1" and single > SINGLE:
        yield Doubt(
            "elements through a wall",
            f"{100 * single:.0f} % of the elements on a cavity reach through its wall: one linear "
            'element is far too stiff there; take solver.element = "P2", or a smaller mesh.size_mm',
        )
