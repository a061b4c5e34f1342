"""A forecast of the pressure at which a chamber's walls balloon, in closed form.

A chamber whose walls are thin and soft becomes round long before its pressure is greatest, and then
is a spherical balloon. Its membrane of thickness t and radius r at rest bears p = 2 t/r P(λ)/λ²,
P being the law's nominal stress in equibiaxial tension. The greatest value is 1.24 μ t/r of
neo-Hooke's law, at λ = 1.38 (Ogden, Non-Linear Elastic Deformations, 1984, section 5.2). Beyond it
the walls grow while the pressure falls. A film in a wall counts as the thickness of material that
is as stiff. Bending, contact and walls that differ are left out: two
solved fingers bear 174 kPa where 191 kPa are forecast (examples/thin_bellows.toml), and 21 kPa
where 11 kPa are (one chamber of the default pneu-net in Ecoflex 00-50).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from dolfingrip.experiments.material_fit.law import balloon, limit_points
from dolfingrip.sections.geometry.adopted import AdoptedGeometry
from dolfingrip.sections.geometry.boxes import TOLERANCE_MM, Box, BoxSolid

if TYPE_CHECKING:
    from dolfingrip.config import Config
    from dolfingrip.sections.material import Material

LARGEST_STRETCH: Final = 12.0
"""Stretch up to which the greatest pressure is sought."""

CHANNEL: Final = 2.0
"""Length by width from which on a hollow is a channel and grows across it alone."""

NEAR: Final = 0.8
"""Part of the forecast pressure from which on a run is told of it."""


class Ballooning(NamedTuple):
    """The chamber that balloons first.

    Attributes:
        wall_mm: its thinnest wall.
        radius_mm: radius of the balloon at rest.
        pressure_kPa: greatest pressure that it bears.
        stretch: of its walls at that pressure.
    """

    wall_mm: float
    radius_mm: float
    pressure_kPa: float
    stretch: float

    def sentence(self) -> str:
        """The forecast in words."""
        return (
            f"walls of {self.wall_mm:.3g} mm around a chamber of {2 * self.radius_mm:.3g} mm may "
            f"balloon near {self.pressure_kPa:.2g} kPa (a thin balloon's estimate, good to a "
            "factor of two); beyond, the pressure falls while they grow; ask for "
            "experiment.control=auto, or take thicker walls, a stiffer material or less pressure"
        )


def forecast(config: Config) -> Ballooning | None:
    """Forecast the greatest pressure that the chambers bear.

    Args:
        config: of a finger.

    Returns:
        The forecast; None where no chamber's walls are known, or the law stiffens before.
    """
    maximum = most(config.material)
    ratio = max((cavity.pressure_ratio for cavity in config.cavity.all.values()), default=1.0)
    if maximum is None or ratio <= 0:
        return None
    stretch, factor = maximum
    forecasts = [
        Ballooning(wall, radius, 2e3 * factor * wall / radius / ratio, stretch)
        for wall, radius in _balloons(config)
    ]
    return min(forecasts, key=lambda balloon: balloon.pressure_kPa, default=None)


def _balloons(config: Config) -> Iterator[tuple[float, float]]:
    """Thinnest wall and radius (mm) of each chamber, of an adopted part of the widest one."""
    geometry = config.geometry
    if isinstance(geometry, AdoptedGeometry) and geometry.chamber_mm:
        yield geometry.wall_mm, geometry.chamber_mm / 2
    if config.mesh.file or (solid := geometry.boxes()) is None:
        return
    for cavity in solid.cavity:
        wall = min(
            thickness_mm(cavity, axis, side, solid) + _film(cavity, axis, side, solid, config)
            for axis in range(3)
            for side in (0, 1)
        )
        yield wall, diameter_mm([high - low for low, high in cavity]) / 2


def diameter_mm(sides_mm: Sequence[float]) -> float:
    """Diameter (mm) at rest of the balloon that a chamber becomes.

    Args:
        sides_mm: of the box around the chamber.
    """
    second, longest = sorted(sides_mm)[1:]
    return longest if longest <= CHANNEL * second else second


def note(config: Config) -> list[str]:
    """Return the forecast in a sentence where a run comes near to it, else nothing.

    Args:
        config: of a finger.
    """
    limit = None if config.experiment.control == "volume" else forecast(config)
    if limit is None or config.of_experiment_kPa[1] < NEAR * limit.pressure_kPa:
        return []
    return [limit.sentence()]


def most(material: Material) -> tuple[float, float] | None:
    """Find the first maximum of P(λ)/λ², its stretch and value (MPa); None if there is none.

    Args:
        material: whose law the wall has.
    """
    energy = partial(material.energy, material.constants())
    turns = limit_points(energy, LARGEST_STRETCH)
    maximum = next((stretch for stretch, greatest in turns if greatest), None)
    return None if maximum is None else (maximum, float(balloon(energy, np.array([maximum]))[0]))


def thickness_mm(cavity: Box, axis: int, side: int, solid: BoxSolid) -> float:
    """Distance (mm) from a cavity's face to the next face outside.

    Args:
        cavity: one of the solid's.
        axis: across the face.
        side: 0 for the face at the cavity's lower end, 1 for that at its upper end.
        solid: that it is in.
    """
    sign, face = (1 if side else -1), cavity[axis][side]
    ends: Sequence[float] = [
        solid.body[axis][side],
        *(
            gap[axis][1 - side]
            for gap in solid.gaps
            if all(
                min(a[1], b[1]) - max(a[0], b[0]) > TOLERANCE_MM
                for i, (a, b) in enumerate(zip(cavity, gap, strict=True))
                if i != axis
            )
        ),
    ]
    beyond = (sign * (end - face) for end in ends)
    return min((gap_mm for gap_mm in beyond if gap_mm > TOLERANCE_MM), default=np.inf)


def _film(cavity: Box, axis: int, side: int, solid: BoxSolid, config: Config) -> float:
    """Thickness (mm) of the walls' material that is as stiff as the films beyond a face."""
    if axis:
        return 0.0
    young_MPa = 3 * config.material.shear_MPa
    face, sign = cavity[0][side], (1 if side else -1)
    return sum(
        film.Et_N_per_mm / young_MPa
        for film in config.film.all.values()
        for _, region in film.regions
        for box in solid.regions.get(region, ())
        if sign * (box[0][1 - side] - face) > -TOLERANCE_MM
    )
