"""What can be asked of a design: readings of an experiment, and numbers of its unloaded shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from dolfingrip.channels import (
    ANGLE,
    CAVITY_VOLUME,
    CHORD_ANGLE,
    FORCE,
    PRESSURE,
    TIP_X,
    TIP_Z,
)
from dolfingrip.config import ConfigError
from dolfingrip.design.campaign.grasps import PICKUP

Experiment = Literal["bending", "blocked_force", "push", "grasp"]

GRASP: Final = "grasp"

READINGS: Final[dict[str, Experiment]] = {
    FORCE.name: "blocked_force",
    ANGLE.name: "bending",
    CHORD_ANGLE.name: "bending",
    TIP_X.name: "bending",
    TIP_Z.name: "bending",
    CAVITY_VOLUME.name: "bending",
    "work_mJ": "bending",
    "peak_stretch": "bending",
    "stiffness_y_N_per_mm": "push",
}
"""Readings with gradients, each with the experiment that is run for it unless another is named."""

FACING: Final = ("least_wall_mm", "least_gap_mm", "least_hollow_mm")
"""Least distances of faces that stand opposite each other: of walls, gaps, and inside a cavity."""

OF_SHAPE: Final = ("cog_offset_mm", "mass_g", *FACING, "overhang_deg")
"""Numbers of the unloaded shape; they take no simulation."""

CELL_QUALITY: Final = "least_cell_quality"
"""Smallest of the scaled Jacobians at cells' corners and of twice the lengths of edges, each by
that of the straight mesh; 1 of a box."""

OF_MANY: Final = (*FACING, "overhang_deg", CELL_QUALITY)
"""Of these, extremes over the whole shape: they can be limited, not improved."""

NO_GRADIENT: Final = {
    "pickup_pressure_kPa": "a grasp with friction remembers its way, and has no adjoint",
    "contact_gap_mm": "a smallest distance has kinks",
    "first_touch_kPa": "the first touch of bellows is a kink",
    "turning_point_kPa": "two lines that fit a curve have no adjoint",
    "stiffness_x_N_per_mm": "it takes two loads; stiffness_y_N_per_mm has one",
}
"""What people ask for that has no gradient here, and why."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number of a design.

    Attributes:
        name: with its unit.
        experiment: that gives it; None of the unloaded shape.
        where: column that sets the place on the experiment's path; "" of the unloaded shape.
        values: of that column; the quantity is the mean over them.
    """

    name: str
    experiment: Experiment | None
    where: str = ""
    values: tuple[float, ...] = ()

    def __str__(self) -> str:
        if not self.where:
            return self.name
        at = ", ".join(f"{value:g}" for value in self.values)
        usual = READINGS.get(self.name) == self.experiment
        other = "" if usual or self.name == PRESSURE.name else f" in {self.experiment}"
        return f"{self.name} at {self.where} = {at}{other}"


def quantity(
    option: str, name: str, places: dict[str, tuple[float, ...]], experiment: Experiment | None
) -> Quantity:
    """The quantity that a table of a design file asks for.

    Args:
        option: key of the file, for messages.
        name: of the quantity.
        places: for each column the values at which it is read.
        experiment: that is run instead of the usual one.

    Raises:
        ConfigError: one line, where there is no such quantity, or no gradient of it.
    """
    if name in NO_GRADIENT:
        raise ConfigError(f"{option} = {name}: no gradient: {NO_GRADIENT[name]}")
    if name in OF_SHAPE:
        if places or experiment:
            raise ConfigError(f"{option} = {name}: of the unloaded shape; allowed: without a place")
        return Quantity(name, None)
    if name == PICKUP:
        if option != "objective" or places or experiment not in (None, GRASP):
            raise ConfigError(
                f"{option} = {name}: of a grasp at experiment.max_pressure_kPa; allowed: "
                "the objective, without a place"
            )
        return Quantity(name, GRASP)
    if name not in (*READINGS, PRESSURE.name):
        known = ", ".join([*READINGS, PRESSURE.name, *OF_SHAPE, PICKUP])
        raise ConfigError(f"{option} = {name}: allowed: {known}")
    if len(places) != 1:
        raise ConfigError(
            f"{option} = {name}: {len(places)} places; allowed: one of at_pressure_kPa, "
            "at_force_N, at_angle_deg"
        )
    ((where, values),) = places.items()
    if name == where:
        raise ConfigError(f"{option} = {name}: given by at_{where}; allowed: another place")
    usual = READINGS[where if name == PRESSURE.name else name]
    if where == FORCE.name:
        usual = "blocked_force"
    found = experiment or usual
    if FORCE.name in (name, where) and found != "blocked_force":
        raise ConfigError(f'experiment = "{found}": allowed: "blocked_force" with {FORCE.name}')
    if name == "stiffness_y_N_per_mm" and (found, where) != ("push", PRESSURE.name):
        raise ConfigError(f'{name} in "{found}": allowed: in "push", at_pressure_kPa')
    return Quantity(name, found, where, values)
