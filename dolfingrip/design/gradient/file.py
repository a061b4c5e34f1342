"""The tables of a design file, and the quantities that may stand in them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import BeforeValidator, Field

from dolfingrip.config import ConfigError
from dolfingrip.design.quantities import index
from dolfingrip.design.quantities.grasp import GRASP, PICKUP
from dolfingrip.design.quantities.quantity import UNITS, Places, Quantity
from dolfingrip.design.quantities.readings import FingerReadings
from dolfingrip.design.quantities.shape import ShapeNumbers
from dolfingrip.sections.section import Section

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
    wanted = index.quantity(said, name, places, experiment)
    if wanted.experiment not in (None, GRASP) and not wanted.where:
        raise ConfigError(
            f"{said}: 0 places; allowed: one of at_pressure_kPa, at_force_N, at_angle_deg"
        )
    return wanted


Numbers = Annotated[tuple[float, ...], Field(strict=False, min_length=1)]
At = float | Numbers | None
Several = BeforeValidator(lambda value: value if isinstance(value, list | tuple) else (value,))
"""One value or a list of several."""
Curve = Annotated[Path, Field(strict=False)]
Four = Annotated[tuple[float, ...], Field(strict=False, min_length=4, max_length=4)]
Experiment = Literal["bending", "blocked_force", "push", "grasp"]


class Placed(Section):
    """A reading at a place of an experiment's path."""

    at_pressure_kPa: At = Field(None, description="a pressure, or several: the mean counts")
    at_force_N: At = Field(None, description="where the blocked force has this value")
    at_angle_deg: At = Field(None, description="where the tip's angle has this value")
    experiment: Experiment | None = Field(None, description="that is run instead of the usual one")

    def quantity(self, option: str, name: str) -> Quantity:
        """Return the quantity of this name at this place."""
        given = {column: getattr(self, f"at_{column}") for column in UNITS.values()}
        places = {
            column: value if isinstance(value, tuple) else (value,)
            for column, value in given.items()
            if value is not None
        }
        return quantity(option, name, places, self.experiment)


class Circle(Section):
    """A straight piece from the clamp on, and a part of a circle towards −x after it."""

    radius_mm: float = Field(gt=0, le=10_000)
    straight_mm: float = Field(0.0, ge=0, le=1000, description="length of the straight piece")
    angle_deg: float | None = Field(
        None, ge=-350, le=350, description="of the part; default: as long as the finger in all"
    )


class Cubic(Section):
    """A cubic Bézier curve."""

    x_mm: Four = Field(description="of its four control points, from the clamp on")
    z_mm: Four = Field(description="of its four control points")


class Objective(Placed):
    """The quantity that is improved."""

    maximise: str | None = Field(None, description="name of a quantity")
    minimise: str | None = Field(None, description="name of a quantity")
    match: Annotated[tuple[Curve, ...], Several] | None = Field(
        None,
        strict=False,
        description="CSV, SVG or DXF with a curve that the back shall follow; of several, one at "
        "each pressure",
    )
    match_circle: Annotated[tuple[Circle, ...], Several] | None = Field(
        None, strict=False, description="that the back shall follow; of several, one each pressure"
    )
    match_cubic: Annotated[tuple[Cubic, ...], Several] | None = Field(
        None, strict=False, description="that the back shall follow; of several, one each pressure"
    )
    match_path: Path | None = Field(
        None, strict=False, description="CSV with the tip's places at pressures that it shall pass"
    )
    ends: Literal["free", "fixed"] = Field("free", description="of the curve that is matched")
    wrap: str | None = Field(
        None, description="food's kind, or an STL file, on which the pressure shall be uniform"
    )


class Limit(Placed):
    """A quantity that is limited."""

    of: str = Field(description="name of a quantity")
    at_most: float | Literal["start"] | None = Field(None, description="in the name's unit")
    at_least: float | Literal["start"] | None = Field(None, description="in the name's unit")


class FreeFormTable(Section):
    """Offsets of the planes of the finger's faces."""

    along: int = Field(5, ge=3, le=40, description="numbers of a field along the finger")
    most_mm: float = Field(0.5, gt=0, le=20, description="largest offset")
    outwards_mm: float | None = Field(
        None, ge=0, le=20, description="largest offset of outer faces outwards; default: most_mm"
    )
    ends: bool = Field(
        True, description="whether outlines of clamp and tip face change, and planes across z"
    )
    faces: Literal["walls", "contact face", "all"] = Field(
        "walls", description="that are bent; the contact face is that which touches food and plate"
    )
    ripple_mm: float = Field(
        0.0, ge=0, le=20, description="amplitude of a ripple of the start, less at the contact face"
    )
    ripple_length_mm: float = Field(10.0, ge=0.1, le=500, description="wavelength of that ripple")


class Scenario(Section):
    """A condition that a design must stand, too; the worst one counts."""

    config: Path | None = Field(None, strict=False, description="another configuration")
    set: tuple[str, ...] = Field((), strict=False, description="section.key=value")
    change: tuple[str, ...] = Field((), strict=False, description="section.key=amount to add")


class Method(Section):
    """How long it is sought."""

    simulations: int = Field(40, ge=1, le=1_000_000, description="largest number of load paths")
    radius: float = Field(
        0.25, gt=0, le=1, description="first step in each variable, as a part of its range"
    )
    starts: int = Field(
        1, ge=1, le=100, description="number of starts; those beyond the first are random"
    )


class FrontTable(Placed):
    """A front instead of one design: the best objective for each limit of another quantity."""

    against: str = Field(description="name of the quantity that is limited")
    sense: Literal["at most", "at least"] = Field("at most", description="how it is limited")
    low: float = Field(description="least limit, in the name's unit")
    high: float = Field(description="largest limit, in the name's unit")
    unsure: float = Field(
        0.005, gt=0, lt=1, description="largest deviation on it, as a part of the objective's range"
    )


class File(Section):
    """A design file."""

    config: Path | None = Field(None, strict=False, description="of the finger; relative to it")
    set: tuple[str, ...] = Field((), strict=False, description="section.key=value")
    objective: Objective = Field(description="what is improved")
    constraints: tuple[Limit, ...] = Field((), strict=False, description="what is held")
    parameters: dict[str, Any] = Field({}, description="key = [low, high]")
    free_form: FreeFormTable | None = None
    scenarios: tuple[Scenario, ...] = Field((), strict=False, description="that it must stand")
    method: Method = Method()
    front: FrontTable | None = None
