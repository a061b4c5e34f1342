"""Materials by name: ``material.name`` stands in place of a law and its constants."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any, Final

from dolfingrip.sections.errors import shown
from dolfingrip.sections.section import outside

NAME: Final = "name"
"""Key of a material's table that names one of these; the resolved configuration has its law."""

KEPT: Final = ("nu", "bulk_MPa", "density_kg_m3", "elongation_at_break")
"""Keys that a named material leaves to the configuration, or that may be told otherwise."""


@cache
def known() -> dict[str, dict[str, Any]]:
    """Return the materials by name: law and constants, stretch, elongation, source and licence."""
    text = files("dolfingrip.sections").joinpath("materials.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def resolved(table: dict[str, Any], defaults: dict[str, Any]) -> dict[str, Any]:
    """Return a material's table with the law and constants of the material that it names.

    Args:
        table: of the configuration; without a name it is returned as it is.
        defaults: values of the keys of all laws where they are not told.

    Raises:
        PydanticCustomError: the name is unknown, or a law or constants are told, too.
    """
    name = table.get(NAME)
    if name is None:
        return table
    if name not in known():
        raise outside(NAME, shown(name), f"allowed: {', '.join(known())}")
    found = known()[name]
    own = {**found["material"], "elongation_at_break": found["elongation_at_break"]}
    told = {k: v for k, v in table.items() if k != NAME and v != defaults.get(k, name)}
    for key, value in told.items():
        if key in defaults and key not in KEPT and value != own.get(key):
            raise outside(key, shown(value), f'allowed: without name = "{name}", which tells it')
    return {**own, **told}
