"""The moduli of a configuration: pressures at equal angles, and forces, are proportional to them.

>>> from dolfingrip.config import Config
>>> moduli(Config())
{'material.mu_MPa': 2.93}
>>> scaled(Config(), 2.0)
('material.mu_MPa=5.86',)
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from dolfingrip.config import Config
from dolfingrip.sections.material import Material

OF_FILM: Final = ("Et_N_per_mm", "fibre_Et_N_per_mm")

Modulus = float | tuple[float, ...]


def moduli(config: Config) -> dict[str, Modulus]:
    """Moduli by key (MPa; N/mm of films): of the material, of regions and of films.

    A bulk modulus is among them if it is given. Moduli of effects and contacts are not.
    """
    return {key: value for key, value in _all(config) if value not in (None, (), 0.0)}


def scaled(config: Config, factor: float) -> tuple[str, ...]:
    """Assignments, as of ``--set``, that make all moduli ``factor`` times as large."""
    found = []
    for key, value in moduli(config).items():
        new = [factor * each for each in value] if isinstance(value, tuple) else factor * value
        found.append(f"{key}={new!r}")
    return tuple(found)


def _all(config: Config) -> Iterator[tuple[str, Modulus]]:
    own = {f"material.{name}": config.material.of(name) for name in config.material.own}
    materials: dict[str, Material] = {"material": config.material, **own}
    for table, material in materials.items():
        for key in (*material.chosen.moduli, "bulk_MPa"):
            yield f"{table}.{key}", getattr(material, key)
    for name, film in config.film.all.items():
        for key in OF_FILM:
            yield f"film.{name}.{key}", getattr(film, key)
