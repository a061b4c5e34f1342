"""Units that names end in, and the conversion of kPa to MPa."""

from __future__ import annotations

KPA = 1e-3
"""MPa per kPa."""

UNITS = {
    "mm": "mm",
    "mm2": "mm²",
    "per_m": "1/m",
    "MPa": "MPa",
    "kPa": "kPa",
    "N": "N",
    "s": "s",
    "deg": "deg",
    "kg_m3": "kg/m³",
    "m_s2": "m/s²",
    "kPa_per_s": "kPa/s",
    "mm_per_s": "mm/s",
    "N_per_s": "N/s",
    "N_per_mm": "N/mm",
    "mm_per_N": "mm/N",
    "rad_per_Nmm": "rad/(N mm)",
    "N_per_mm3": "N/mm³",
    "Nmm_per_rad": "N mm/rad",
    "degC": "°C",
    "per_degC": "1/°C",
    "GB": "GB",
    "g": "g",
    "mJ": "mJ",
}
"""Units by the ending of a key."""


def unit(key: str) -> str:
    """Return the unit that a key's name ends in; "" for a pure number.

    Args:
        key: with or without the names of sections.
    """
    return UNITS.get(_ending(key), "")


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
    return max((each for each in UNITS if key.endswith(f"_{each}")), key=len, default="")


UNITS_MM = {"mm": 1.0, "cm": 10.0, "in": 25.4, "m": 1000.0}
"""Millimetres of each unit that a part's file may be in."""

LENGTHS_MM = (1.0, 1000.0)
"""Shortest and longest part whose unit is not doubted."""


def doubted(length_mm: float, scale: float) -> tuple[str, ...]:
    """Return a doubt about a file's unit, where its part is far too short or long for a finger.

    Args:
        length_mm: of the part.
        scale: mm of the unit that was taken for the file's.

    Returns:
        One sentence with another unit and the length in it, or none.
    """
    low, high = LENGTHS_MM
    if low <= length_mm <= high:
        return ()
    others = {name: length_mm / scale * mm for name, mm in UNITS_MM.items()}
    fits = [f"--unit {name} makes {x:.4g} mm of it" for name, x in others.items() if low < x < high]
    return (f"{length_mm:.4g} mm long: in another unit? {fits[-1] if fits else 'scale it'}",)
