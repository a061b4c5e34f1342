"""The channels of measurements and simulations: one object describes each column.

A new channel is one entry here, and a ``Reading`` in a file of its own in ``mechanics/readings``.
All other code asks the channel: for columns of results and of measured data, units, labels, noise,
tolerances, ranges, and for its change if all moduli change.

>>> ANGLE.label, TRANSVERSE_STRAIN.label
('Tip angle (°)', 'Transverse strain (–)')
>>> [each.name for each in readings("bar")]
['force_N', 'transverse_strain']
>>> CHANNELS["force_N"] is FORCE
True
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final, Literal

from dolfingrip import plugins

Part = Literal["finger", "plate", "bar", "modes", "gripper"]
"""The objects that are read: a finger, the plate that it presses on, a coupon, a finger's small
vibrations, a gripper."""

WORDS: Final[Mapping[str, str]] = {
    "experiment": "name of the experiment",
    "specimen": "name of the specimen; of a simulation `simulated`",
    "cycle": "number of the cycle, from 1 on",
    "branch": "`loading` (the load goes away from 0, as suction does, too), `unloading` (it comes "
    "back towards 0), `hold` (it waits), `approach` or `lift` (of a grasp)",
}
"""What the columns mean that name the experiment, specimen, cycle and branch of a row."""

WHO: Final = tuple(WORDS)
"""Columns that name the experiment, specimen, cycle and branch of a row."""

SYMBOLS: Final[Mapping[str, str]] = {
    "deg": "°",
    "mm2": "mm²",
    "mm3": "mm³",
    "per_m": "1/m",
    "N_per_mm": "N/mm",
    "l_per_min": "l/min",
    "": "–",
}
"""Printed forms of units that differ from the ends of names."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """A column of numbers.

    Attributes:
        name: name of the column, with its unit at the end.
        unit: unit in the form at the name's end; "" for a ratio.
        title: name in words, for an axis.
        about: what it is, for the table of columns; "" if its title says it.
        short: title above a column of a table; "" if it is ``title``.
        form: format of a printed number, such as ``.2f``.
        of: parts that it is read of; empty for time and controls.
        plausible: lowest and highest value that is no slip of the pen; None if no instrument reads
            the channel.
        least: what the lowest plausible value is; "" if it is nothing but implausible.
        noise: standard deviation of an ordinary instrument's readings (engineering guess).
        tolerance: largest difference of a simulation that is computed again from a stored one: a
            tenth of the noise or less, and well above Newton's tolerance.
        from_rest: whether it counts from the state at rest.
        in_proportion: whether it grows by the factor by which all moduli and loads grow; other
            readings then stay.
        grows: whether it grows with the load, and so tells how far the body is deformed.
        synthetic: whether a synthetic measurement has it; it has one of two readings of a picture.
        reading: file in ``mechanics/readings`` with a ``Reading`` that only needs the model; of a
            plugin a function of the model that returns one; "" if the rig makes it and uses other
            parts.
        added: 1 more than that of the channels that its parts had before, so that a diagnosis'
            stored simulations without it are computed again.
    """

    name: str
    unit: str
    title: str
    about: str = ""
    short: str = ""
    form: str = "g"
    of: tuple[Part, ...] = ()
    plausible: tuple[float, float] | None = None
    least: str = ""
    noise: float = 0.0
    tolerance: float = 0.0
    from_rest: bool = False
    in_proportion: bool = False
    grows: bool = False
    synthetic: bool = True
    reading: str | Callable[[Any], Any] = ""
    added: int = 0

    @property
    def symbol(self) -> str:
        """The printed unit."""
        return SYMBOLS.get(self.unit, self.unit)

    @property
    def label(self) -> str:
        """The title with the unit, for an axis."""
        return f"{self.title} ({self.symbol})"

    @property
    def heading(self) -> str:
        """The short title with the unit, for a table."""
        return f"{self.short or self.title} ({self.symbol})"

    def said(self, value: float) -> str:
        """Write a value, read between two rows as well, with its unit.

        Args:
            value: in the channel's unit.
        """
        form = ".1f" if self.form == "g" else self.form
        return f"{value:z{form}}{'' if self.symbol == '°' else ' '}{self.symbol}"

    def called(self, title: str) -> Channel:
        """A channel with these readings and another title."""
        return replace(self, title=title, short="")


AMBIENT_KPA: Final = 101.325
"""Absolute pressure of the air around: a standard atmosphere."""

VACUUM_KPA: Final = -101.3
"""Absolute vacuum, seen from the air around: no pump goes below."""

TIME = Channel(
    name="time_s",
    unit="s",
    title="Time",
    about="time since the first reading",
    form=".1f",
    plausible=(0.0, 1e9),
)
PRESSURE = Channel(
    name="pressure_kPa",
    unit="kPa",
    title="Pressure",
    about="pressure of the supply above that of the air around",
    plausible=(VACUUM_KPA, 1e4),
    least="absolute vacuum",
    noise=0.5,
)
VOLUME = Channel(
    name="volume_ml",
    unit="ml",
    title="Volume",
    about="liquid that a pump has put into the cavity since rest",
    plausible=(-1e6, 1e6),
    noise=0.1,
)
ANGLE = Channel(
    name="angle_deg",
    unit="deg",
    title="Tip angle",
    about="turn of the tip face in the plane of bending, since rest",
    short="Angle",
    form=".1f",
    of=("finger",),
    plausible=(-720.0, 720.0),
    noise=0.3,
    tolerance=0.01,
    from_rest=True,
    grows=True,
)
FORCE = Channel(
    name="force_N",
    unit="N",
    title="Force",
    about="of a finger: its force on the plate, normal to it; of a coupon: its tension",
    form=".3f",
    of=("plate", "bar"),
    plausible=(-1e5, 1e5),
    noise=0.02,
    tolerance=1e-3,
    in_proportion=True,
    grows=True,
)
DISPLACEMENT = Channel(
    name="displacement_mm",
    unit="mm",
    title="Travel",
    about="travel of the crosshead that pulls a coupon",
    form=".2f",
    plausible=(-1e3, 1e4),
    noise=0.005,  # of the crosshead that pulled the NinjaFlex coupons
)
TIP_X = Channel(
    name="tip_x_mm",
    unit="mm",
    title="Tip's displacement along x",
    about="mean displacement of the tip face along x, towards which the finger bends",
    short="Tip x",
    form=".2f",
    of=("finger",),
    plausible=(-1e3, 1e3),
    noise=0.1,
    tolerance=0.01,
    from_rest=True,
)
TIP_Z = replace(
    TIP_X, name="tip_z_mm", title="Tip's displacement along z", short="Tip z",
    about="mean displacement of the tip face along z, from the clamp to the tip at rest",
)  # fmt: skip
TIP_Y = replace(
    TIP_X, name="tip_y_mm", title="Tip's displacement along y", short="Tip y", plausible=None,
    about="mean displacement of the tip face along y, out of the plane of bending",
)  # fmt: skip
TIP_ROTATION = Channel(
    name="tip_rotation_deg",
    unit="deg",
    title="Tip's rotation",
    about="angle by which the tip face has turned in space, since rest",
    form=".1f",
    of=("finger",),
)
TIP_ROTATIONS: Final = tuple(
    replace(
        TIP_ROTATION, name=f"tip_rotation_{axis}_deg", title=f"Tip's rotation about {axis}",
        about=f"part of the tip face's rotation vector along {axis}, by the right-hand rule",
    )
    for axis in "xyz"
)  # fmt: skip
"""The rotation vector of the tip face. In the plane of bending that about y is −angle_deg."""
BENDING_ANGLE = replace(
    TIP_ROTATION, name="bending_angle_deg", title="Bending angle in space",
    about="angle between the tip face's normals at rest and now, in whichever direction",
)  # fmt: skip
BENDING_DIRECTION = replace(
    TIP_ROTATION, name="bending_direction_deg", title="Bending direction",
    about="direction in which the tip leans: 0 forwards (towards −x), 90 towards y, ±180 "
    "backwards; empty where it is straight",
)  # fmt: skip
CHORD_ANGLE = replace(
    ANGLE, name="chord_angle_deg", title="Chord angle", short="", synthetic=False,
    about="turn of the line from the clamp to the tip, since rest",
)  # fmt: skip
CAVITY_PRESSURE = Channel(
    name="cavity_pressure_kPa",
    unit="kPa",
    title="Pressure in the cavity",
    about="pressure in the cavity; it lags behind that of the supply where a line is modelled",
    of=("finger",),
)
CAVITY_VOLUME = Channel(
    name="cavity_volume_mm3",
    unit="mm3",
    title="Volume of the cavity",
    about="volume that the cavity encloses, of the whole finger",
    of=("finger",),
)


SUPPLY: Final = "_supply_kPa"
"""End of the column of a cavity's own supply."""
OF_CAVITIES: Final = "cavity_"
"""Beginning of the columns of one of several cavities, which no instrument reads."""


def of_cavity(name: str) -> tuple[Channel, Channel]:
    """Return the channels of one of several cavities: its pressure and its volume.

    Args:
        name: group of the cavity.
    """
    name = _numbered(name)
    return (
        replace(CAVITY_PRESSURE, name=f"{name}_pressure_kPa", title=f"Pressure in {name}",
                about=f"pressure in {name}"),
        replace(CAVITY_VOLUME, name=f"{name}_volume_mm3", title=f"Volume of {name}",
                about=f"volume of {name}, of the whole finger"),
    )  # fmt: skip


def supply_of(name: str) -> Channel:
    """Return the channel of a cavity's own supply, which is prescribed.

    Args:
        name: group of the cavity.
    """
    name = _numbered(name)
    return replace(CAVITY_PRESSURE, name=f"{name}{SUPPLY}", title=f"Supply of {name}",
                   about=f"prescribed pressure of the supply of {name}")  # fmt: skip


@cache
def cavity_of_supply(column: str) -> str | None:
    """Return the group of the cavity whose supply a column has; None of another column.

    Args:
        column: of a table.
    """
    match = re.fullmatch(rf"{OF_CAVITIES}([1-9]\d*){SUPPLY}", column)
    if match is None:
        return None
    return "cavity" if match[1] == "1" else f"{OF_CAVITIES}{match[1]}"


def _numbered(name: str) -> str:
    """A cavity's group with its number, which that of the first one lacks."""
    return f"{OF_CAVITIES}1" if name == "cavity" else name


def of_band(column: str) -> tuple[str, str]:
    """Return the columns of the lower and the upper end of a reading's band.

    Args:
        column: of the reading.
    """
    return f"low_{column}", f"high_{column}"


CURVE = Channel(
    name="curve_mean_square_mm2",
    unit="mm2",
    title="Mean square distance from the curve",
    about="mean square of the distances of the back's middle line from the configuration's curve",
)

CURVE_PARTS: Final = tuple(f"curve_part_{i}_mm" for i in range(1, 17))
"""Parts of the distances, whose squares add up to nearly the mean square; no column of a result."""


def marker(number: int, axis: str) -> Channel:
    """Return the channel of a marker's place on the middle line of the back.

    Args:
        number: from the clamp, from 1 on.
        axis: ``x`` or ``z``.
    """
    return replace(
        TIP_X, name=f"marker_{number}_{axis}_mm", title=f"Marker {number}, {axis}", short="",
        about=f"place of marker {number} along {axis}", from_rest=False,
    )  # fmt: skip


def curvature(number: int) -> Channel:
    """Return the channel of the line's curvature at a marker between two others.

    Args:
        number: of the marker, from 2 on.
    """
    return Channel(name=f"curvature_{number}_per_m", unit="per_m", title=f"Curvature at {number}",
                   about=f"turn of the line at marker {number} by its length, positive towards −x",
                   form=".2f", of=("finger",), plausible=(-1e3, 1e3), noise=1.0,
                   tolerance=0.1)  # fmt: skip


@cache
def at_marker(column: str) -> Channel | None:
    """Return the channel that a marker's column is of; None of another column.

    Args:
        column: of a table.
    """
    match = re.fullmatch(r"marker_([1-9]\d*)_([xz])_mm|curvature_([1-9]\d*)_per_m", column)
    if match is None:
        return None
    return curvature(int(match[3])) if match[3] else marker(int(match[1]), match[2])


OBSTACLE: Final = tuple(
    Channel(name=f"obstacle_{name}", unit=unit, title=title, about=about, form=form)
    for name, unit, title, about, form in (
        ("N", "N", "Force on the obstacle", "sum of the normal forces on the obstacle", ".3f"),
        ("area_mm2", "mm2", "Area on the obstacle", "area of the skin at rest that presses on the "
         "obstacle", ".1f"),
        ("pressure_kPa", "kPa", "Pressure on the obstacle", "mean contact pressure on that area",
         ".2f"),
        ("lift_N", "N", "Lift of the obstacle", "largest force towards the clamp that these "
         "pressures and friction (`obstacle.friction`) bear; three fingers around food lift three "
         "times as much", ".3f"),
        ("spread", "", "Spread of the pressure", "standard deviation of the contact pressure on "
         "that area by its mean", ".3f"),
    )
)  # fmt: skip
"""Readings of what stands beside a finger, in a configuration with ``[obstacle]``."""

AIR_SUPPLY: Final = tuple(
    Channel(name=name, unit=unit, title=title, about=about, form=form)
    for name, unit, title, about, form in (
        ("source_kPa", "kPa", "Pressure of the source", "pressure of the supply's source", ".2f"),
        ("tube_kPa", "kPa", "Pressure in the tube", "pressure behind the supply's valve", ".2f"),
        ("gauge_kPa", "kPa", "Pressure at the gauge", "pressure where the supply's gauge is "
         "(`supply.gauge_part`)", ".2f"),
        ("inflow_l_per_min", "l_per_min", "Flow into the cavity", "flow of free air through the "
         "tube into the cavities, less what leaks", ".3f"),
        ("air_mg", "mg", "Air", "mass of the air in source, tube and cavities", ".3f"),
        ("air_error", "", "Error of the air's balance", "mass of the air against that at rest and "
         "what has entered since, as a part of it", ".1e"),
    )
)  # fmt: skip
"""Readings of a supply of air, in a configuration with ``[supply]``."""

ENERGIES: Final = tuple(
    Channel(name=name, unit="mJ", title=title, about=about, form=".4f")
    for name, title, about in (
        ("kinetic_energy_mJ", "Kinetic energy", "kinetic energy, of the whole finger"),
        ("energy_mJ", "Energy", "kinetic energy and the potential of all forces, those of the "
         "pressure among them, of the whole finger; it is kept while the pressure is constant and "
         "nothing is lost"),
    )
)  # fmt: skip
"""Readings of a finger with inertia (``experiment.dynamic``)."""


def of_line(markers: int | Sequence[Any], *, curve: bool) -> tuple[Channel, ...]:
    """Return the channels of the back's middle line that a configuration asks for.

    Args:
        markers: number of markers, or their places.
        curve: whether the distance from a curve is read.
    """
    count = markers if isinstance(markers, int) else len(markers)
    places = (marker(i, axis) for i in range(1, count + 1) for axis in "xz")
    turns = (curvature(i) for i in range(2, count))
    return (*places, *turns, *((CURVE,) if curve else ()))


CONTACT_GAP = Channel(
    name="contact_gap_mm",
    unit="mm",
    title="Smallest gap between bellows",
    about="smallest distance between neighbouring bellows",
    of=("finger",),
)
WALL_GAP = Channel(
    name="wall_gap_mm",
    unit="mm",
    title="Smallest gap inside a cavity",
    about="smallest distance of opposite walls of a cavity, where these may meet and are near",
    of=("finger",),
)
LARGEST_STRETCH = Channel(
    name="largest_stretch",
    unit="",
    title="Largest stretch",
    about="largest principal stretch at an integration point",
    form=".3f",
    of=("finger",),
)
BREAK_SHARE = Channel(
    name="break_share",
    unit="",
    title="Share of the elongation at break",
    about="largest elongation, by the elongation at break of its material, where that is told; a "
    "wall breaks from 1 on",
    form=".2f",
    of=("finger",),
)
PLATE_GAP = Channel(
    name="plate_gap_mm",
    unit="mm",
    title="Gap to the plate",
    about="distance from the finger to the force sensor's plate",
    of=("plate",),
)
NOMINAL_STRAIN = Channel(
    name="nominal_strain",
    unit="",
    title="Nominal strain",
    about="travel divided by the gauge length",
    form=".3f",
    of=("bar",),
)
NOMINAL_STRESS = Channel(
    name="nominal_stress_MPa",
    unit="MPa",
    title="Nominal stress",
    about="force divided by the cross-section at rest",
    form=".3f",
    of=("bar",),
)
TRANSVERSE_STRAIN = Channel(
    name="transverse_strain",
    unit="",
    title="Transverse strain",
    about="change of the width divided by the width at rest",
    form=".4f",
    of=("bar",),
    plausible=(-1.0, 1.0),
    # a camera of 2,448 pixels sees 60 mm, so 3 mm of width are 120 pixels; each of the two edges is
    # found to a sixth of one
    noise=0.002,
    tolerance=1e-4,
    reading="transverse",
    added=1,
)

FREQUENCIES: Final = tuple(
    Channel(
        name=f"frequency_{i}_Hz",
        unit="Hz",
        title=f"Frequency {i}",
        about=f"natural frequency {i} of small vibrations at constant pressure",
        form=".2f",
        of=("modes",),
        plausible=(0.0, 1e5),
        noise=0.05,  # a ring-down of a few seconds
        tolerance=0.005,
        synthetic=False,
    )
    for i in (1, 2, 3, 4)
)
DAMPINGS: Final = tuple(
    Channel(
        name=f"damping_ratio_{i}",
        unit="",
        title=f"Damping ratio {i}",
        about=f"of vibration {i}: ζ, by which one swing is exp(−2πζ/√(1 − ζ²)) times that a period "
        "before",
        form=".4f",
        of=("modes",),
        plausible=(0.0, 1.0),
        noise=0.005,
        tolerance=5e-4,
        synthetic=False,
    )
    for i in (1, 2, 3, 4)
)

FINGERS: Final[Mapping[str, str]] = {"A": "thumb A", "B": "finger B", "C": "finger C"}
"""Names of a gripper's fingers by their letters."""


def _gripper(name: str, unit: str, title: str, about: str, form: str = ".3f") -> Channel:
    return Channel(name=name, unit=unit, title=title, about=about, form=form, of=("gripper",))


GRIPPER: Final = (
    _gripper("table_z_mm", "mm", "Table", "height of the table, seen from the gripper: the gripper "
             "stands still and the table sinks in the lift"),
    *(_gripper(f"object_{axis}_mm", "mm", f"Food {axis}", "place of the food's centre of gravity, "
               f"seen from the gripper, along {axis}", ".2f") for axis in "xyz"),
    _gripper("object_height_mm", "mm", "Food above table", "height of the food above where it "
             "stood on the table: 0 until it is lifted", ".2f"),
    _gripper("object_turn_deg", "deg", "Food's turn", "angle by which the food has turned", ".1f"),
    *(_gripper(f"object_turn_{axis}_deg", "deg", f"Food's turn about {axis}", "part of the food's "
               f"rotation vector along {axis}", ".1f") for axis in "xyz"),
    *(_gripper(f"angle_{letter}_deg", "deg", f"Angle of {who}", f"turn of the tip face of {who} "
               "towards the food, since rest", ".1f") for letter, who in FINGERS.items()),
    *(_gripper(f"normal_{letter}_N", "N", f"Normal force of {who}", f"sum of the normal forces of "
               f"{who} on the food") for letter, who in FINGERS.items()),
    *(_gripper(f"lift_{letter}_N", "N", f"Lift of {who}", f"vertical part of all forces of {who} "
               "on the food, friction included") for letter, who in FINGERS.items()),
    _gripper("table_N", "N", "Table force", "normal force of the table on the food"),
    _gripper("slip_mm", "mm", "Slip", "how far the food has slid so far along the finger on which "
             "it slid farthest: mean over its points, weighted by their normal forces", ".2f"),
    _gripper("contact_pressure_kPa", "kPa", "Contact pressure", "largest pressure of a finger on "
             "the food", ".1f"),
    _gripper("force_closure", "", "Force closure", "largest load, in the worst direction, that "
             "the contacts can bear for each newton of normal force (–); 0: none"),
    _gripper("pressure_mJ", "mJ", "Work of the pressure", "work of the pressure so far"),
    _gripper("friction_mJ", "mJ", "Dissipated", "energy that sliding has dissipated so far"),
    _gripper("energy_error_mJ", "mJ", "Energy's error", "error of the energy balance so far"),
    _gripper("momentum_error_N", "N", "Momentum's error", "largest error of the food's balance of "
             "momentum in any step so far, |m Δv/Δt − ΣF|"),
    _gripper("opening_mm", "mm", "Opening", "horizontal distance from the thumb's tip to the "
             "middle between the tips of fingers B and C", ".1f"),
)  # fmt: skip
"""The readings of a gripper with its food, in the laboratory's frame: z points upwards."""


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a deformed body that pictures are coloured by.

    Attributes:
        name: name in commands and pages.
        array: name in ``fields.pvd``, with its unit at the end.
        title: name in words.
        unit: printed unit.
        least: lowest value of the scale, which does not change from step to step.
    """

    name: str
    array: str
    title: str
    unit: str
    least: float = 0.0

    @property
    def label(self) -> str:
        """The title with the unit."""
        return f"{self.title} ({self.unit})"


MOVED = Field("displacement", "displacement_mm", "Displacement magnitude", "mm")
STRETCH = Field("stretch", "principal_stretch", "Largest principal stretch", "–", least=1.0)
MISES = Field("mises", "von_mises_MPa", "Von Mises stress", "MPa")
STRESS = Field("stress", "principal_stress_MPa", "Largest principal Cauchy stress", "MPa")
ENERGY = Field("energy", "strain_energy_mJ_mm3", "Strain energy density", "mJ/mm³")
CONTACT = Field("contact", "contact_pressure_kPa", "Contact pressure", "kPa")
INSIDE = Field("pressure", "cavity_pressure_kPa", "Pressure on the chamber walls", "kPa")

Quantity = Literal["displacement", "stretch", "mises", "stress", "energy", "contact", "pressure"]
"""Names of the fields."""

Colour = Literal[Quantity, "none"]
"""What pictures are coloured by: a field, or nothing."""

FIELDS: Final = {
    each.name: each for each in (MOVED, STRETCH, MISES, STRESS, ENERGY, CONTACT, INSIDE)
}
"""All fields by name."""


class _Channels(dict[str, Channel]):
    """Channels by name; those of markers, of any number, are made on request."""

    def __missing__(self, name: str) -> Channel:
        channel = at_marker(name)
        if channel is None:
            raise KeyError(name)
        return channel


CHANNELS: Final = _Channels(
    (each.name, each)
    for each in (*list(globals().values()), *TIP_ROTATIONS, *FREQUENCIES, *DAMPINGS, *GRIPPER)
    if isinstance(each, Channel)
)
"""All of the above by name, in their order, which is that of columns in files."""


def read_of(*parts: Part) -> tuple[Channel, ...]:
    """Channels that are read of these parts; controls are not among them."""
    return tuple(channel for channel in CHANNELS.values() if set(channel.of) & set(parts))


def readings(*parts: Part) -> tuple[Channel, ...]:
    """Channels that instruments read of these parts, part by part, by name."""
    by_part = [
        sorted((c for c in read_of(part) if c.plausible), key=lambda c: c.name) for part in parts
    ]
    return tuple(dict.fromkeys(channel for some in by_part for channel in some))


def measured() -> tuple[Channel, ...]:
    """Channels that instruments read as a load goes on, and controls and time."""
    read = (channel for channel in CHANNELS.values() if channel.plausible is not None)
    return tuple(channel for channel in read if channel.of != ("modes",))


def of_plugins(*parts: Part) -> tuple[Any, ...]:
    """Functions by which plugins read these parts."""
    return tuple(channel.reading for channel in read_of(*parts) if callable(channel.reading))


for _plugin in plugins.of_group("readings"):  # last, as its file imports this one
    for _channel in vars(_plugin.load()).values():
        if (
            isinstance(_channel, Channel)
            and CHANNELS.setdefault(_channel.name, _channel) != _channel
        ):
            raise plugins.PluginError(
                f"--plugin {_plugin.path}: {_channel.name} is taken; allowed: another name"
            )
