"""Units that names end in, and the conversion of kPa to MPa."""

from __future__ import annotations

from typing import Final, NamedTuple

KPA = 1e-3
"""MPa per kPa."""


class Unit(NamedTuple):
    """A unit, and the sizes that numbers in it have in a finger, its rig and its laboratory.

    Attributes:
        text: as people read it.
        least, most: a number that says something of such a thing is not smaller or larger.
    """

    text: str
    least: float
    most: float


NOTHING: Final = 1e-30
"""What is nearer to 0 is no size of anything; what rounding leaves of a 0 is larger."""

UNITS: Final = {
    "mm": Unit("mm", 0.001, 1e4),
    "mm2": Unit("mm²", 1e-6, 1e6),
    "per_m": Unit("1/m", 1e-6, 1e6),
    "MPa": Unit("MPa", 1e-6, 1e6),
    "kPa": Unit("kPa", 0.0001, 1e4),
    "N": Unit("N", 1e-9, 100000),
    "s": Unit("s", 1e-9, 1e9),
    "Hz": Unit("Hz", 1e-6, 1e6),
    "deg": Unit("deg", 1e-6, 720),
    "kg_m3": Unit("kg/m³", 1, 100000),
    "m_s2": Unit("m/s²", 1e-6, 1000),
    "kPa_per_s": Unit("kPa/s", 1e-6, 1e6),
    "mm_per_s": Unit("mm/s", 1e-6, 1e6),
    "N_per_s": Unit("N/s", 1e-9, 1000),
    "N_per_mm": Unit("N/mm", 1e-6, 1e6),
    "mm_per_N": Unit("mm/N", 1e-9, 1000),
    "rad_per_Nmm": Unit("rad/(N mm)", 1e-12, 1),
    "N_per_mm3": Unit("N/mm³", 1e-9, 1e6),
    "Nmm_per_rad": Unit("N mm/rad", 1e-6, 1e9),
    "degC": Unit("°C", 1e-6, 1000),
    "per_degC": Unit("1/°C", 1e-9, 1),
    "GB": Unit("GB", 0.001, 100000),
    "g": Unit("g", 1e-6, 1e6),
    "mJ": Unit("mJ", 1e-9, 1e6),
    "cm3": Unit("cm³", 1e-6, 1e6),
    "ml": Unit("ml", 1e-6, 1e6),
    "ml_per_s": Unit("ml/s", 1e-6, 1e6),
    "l_per_min": Unit("l/min", 1e-6, 1e4),
    "dm3_per_s_bar": Unit("dm³/(s bar)", 1e-9, 1000),
}
"""Units by the ending of a key."""

PURE: Final = Unit("", 1e-6, 1e6)
"""Of keys without a unit in their names."""

_ONE: Final = Unit("", 1.0, 1.0)
"""What stands above the line of a unit such as 1/N."""


def of(key: str) -> Unit:
    """Return the unit that a key's name ends in, with the sizes of numbers in it.

    Args:
        key: with or without the names of sections.

    >>> of("square_per_N").least, unit("compliance_deg_per_kPa")
    (1e-05, 'deg/kPa')
    """
    ending = _ending(key)
    if ending in UNITS or not ending:
        return UNITS.get(ending, PURE)
    top, _, bottom = ending.rpartition("per_")
    above, below = UNITS.get(top.removesuffix("_"), _ONE), UNITS[bottom]
    text = f"{above.text or 1}/{below.text}"
    return Unit(text, above.least / below.most, above.most / below.least)


def sized(text: str) -> Unit:
    """Return the unit of a text, with the sizes of numbers in it.

    Args:
        text: as people read it; those of a pure number where it is no unit of a key.
    """
    return next((unit for unit in UNITS.values() if unit.text == text), PURE)


def unit(key: str) -> str:
    """Return the unit that a key's name ends in; "" for a pure number.

    Args:
        key: with or without the names of sections.

    >>> unit("square_per_N"), unit("gap_mm"), unit("gain"), unit("designs_per_job")
    ('1/N', 'mm', '', '')
    """
    return of(key).text


def words(key: str) -> str:
    """Return the name of a key in words, without its sections and its unit.

    Args:
        key: with or without the names of sections.

    >>> words("material.density_kg_m3")
    'Density'
    """
    name = key.rpartition(".")[2].removesuffix(f"_{_ending(key)}").replace("_", " ")
    return name[:1].upper() + name[1:]


def _ending(key: str) -> str:
    """The end of a key that is its unit: one of :data:`UNITS`, or one by another."""
    ending = max((name for name in UNITS if key.endswith(f"_{name}")), key=len, default="")
    above = key.removesuffix(f"_{ending}")
    if not ending or not above.endswith("_per"):
        return ending
    return f"{_ending(above.removesuffix('_per'))}_per_{ending}".removeprefix("_")


UNITS_MM = {
    "mm": 1.0, "cm": 10.0, "in": 25.4, "m": 1000.0, "um": 1e-3, "ft": 304.8, "pt": 25.4 / 72,
}  # fmt: skip
"""Millimetres of each unit of length that a file may be in."""

OF_PARTS = ("mm", "cm", "in", "m")
"""Units that a part's file without a unit may be in."""

LENGTHS_MM = (10.0, 1000.0)
"""Shortest and longest part whose unit is not doubted."""


def doubted(length_mm: float, scale: float) -> tuple[str, ...]:
    """Return a doubt about a file's unit, where its part is far too short or long for a finger.

    Args:
        length_mm: of the part.
        scale: mm of the unit that was taken for the file's.

    Returns:
        One sentence with other units and the length in each, or none.
    """
    low, high = LENGTHS_MM
    if low <= length_mm <= high:
        return ()
    others = {name: length_mm / scale * UNITS_MM[name] for name in OF_PARTS}
    fits = [f"--unit {name} makes {x:.4g} mm of it" for name, x in others.items() if low < x < high]
    return (f"{length_mm:.4g} mm long: in another unit? {' or '.join(fits) or 'scale it'}",)
