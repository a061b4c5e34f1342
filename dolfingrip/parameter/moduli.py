"""The moduli of a configuration: pressures at equal angles, and forces, are proportional to them.

>>> from dolfingrip.config import Config
>>> moduli(Config())
{'material.mu_MPa': 2.93}
>>> scaled(Config(), 2.0)
{'material.mu_MPa': 5.86}
"""

from __future__ import annotations

from dolfingrip.config import Change, Config
from dolfingrip.sections.section import Role

Modulus = float | tuple[float, ...]


def moduli(config: Config) -> dict[str, Modulus]:
    """Return moduli by key (MPa; N/mm of films): of the material, of regions and of films.

    A bulk modulus is among them if it is given. Moduli of effects and contacts are not.

    Args:
        config: of the finger, or of a coupon.
    """
    bodies = {name: each for name, each in config.tables.items() if each.role is Role.BODY}
    inner = {f"{n}.{key}": t for n, each in bodies.items() for key, t in each.inner.items()}
    return {
        f"{path}.{key}": value
        for path, table in (bodies | inner).items()
        for key in type(table).model_fields
        if table.is_modulus(key) and table.movable(key)
        if (value := getattr(table, key)) not in (None, (), 0.0)
    }


def scaled(config: Config, factor: float) -> Change:
    """Return the change that makes all moduli ``factor`` times as large.

    Args:
        config: whose moduli they are.
        factor: above 0.
    """
    return {
        key: [factor * each for each in value] if isinstance(value, tuple) else factor * value
        for key, value in moduli(config).items()
    }
