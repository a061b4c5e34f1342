"""Quantities that have a gradient, and extremes over the unloaded shape."""

from __future__ import annotations

from typing import Final

from dolfingrip.config import ConfigError
from dolfingrip.design.quantities import index
from dolfingrip.design.quantities.grasp import GRASP, PICKUP
from dolfingrip.design.quantities.quantity import Places, Quantity
from dolfingrip.design.quantities.readings import FingerReadings
from dolfingrip.design.quantities.shape import ShapeNumbers

FACING: Final = ("least_wall_mm", "least_gap_mm", "least_hollow_mm")
"""Least distances of faces that stand opposite each other: of walls, gaps, and inside a cavity."""

OVERHANG: Final = "overhang_deg"

CELL_QUALITY: Final = "least_cell_quality"
"""Smallest of the scaled Jacobians at cells' corners and of twice the lengths of edges, each by
that of the straight mesh; 1 of a box."""

OF_MANY: Final = (*FACING, OVERHANG, CELL_QUALITY)
"""Extremes over the whole shape: they can be limited, not improved."""

NO_GRADIENT: Final = {
    "pickup_pressure_kPa": "a grasp with friction remembers its way, and has no adjoint",
    "contact_gap_mm": "a smallest distance has kinks",
    "plate_gap_mm": "a smallest distance has kinks",
    "first_touch_kPa": "the first touch of bellows is a kink",
    "turning_point_kPa": "two lines that fit a curve have no adjoint",
    "stiffness_x_N_per_mm": "it takes two loads; stiffness_y_N_per_mm has one",
}
"""Quantities that people ask for and that have no gradient here, and why."""

ALLOWED: Final = (
    *(name for name in FingerReadings.names if name not in NO_GRADIENT),
    *ShapeNumbers.names,
    *(*FACING, OVERHANG, PICKUP),
)
"""Quantities of a design file."""


def quantity(option: str, name: str, places: Places, experiment: str | None) -> Quantity:
    """Return the quantity that a table of a design file asks for.

    Args:
        option: key of the file, for messages.
        name: of the quantity.
        places: for each column the values at which it is read.
        experiment: that is run instead of the usual one.

    Returns:
        The quantity.

    Raises:
        ConfigError: one line, where there is no such quantity, or no gradient of it.
    """
    said = f"{option} = {name}"
    if name in NO_GRADIENT:
        raise ConfigError(f"{said}: no gradient: {NO_GRADIENT[name]}")
    if name not in ALLOWED:
        raise ConfigError(f"{said}: allowed: {', '.join(ALLOWED)}")
    if name in OF_MANY:
        return ShapeNumbers().quantity(said, name, places, experiment)
    if name == PICKUP and (
        option.partition(".")[0] != "objective" or places or experiment not in (None, GRASP)
    ):
        raise ConfigError(
            f"{said}: of a grasp at experiment.max_pressure_kPa; allowed: the objective, without a "
            "place"
        )
    found = index.quantity(said, name, places, experiment)
    if found.experiment not in (None, GRASP) and not found.where:
        raise ConfigError(
            f"{said}: 0 places; allowed: one of at_pressure_kPa, at_force_N, at_angle_deg"
        )
    return found
