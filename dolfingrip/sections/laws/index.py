"""The index of laws of the base material: files of this folder, and plugins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from dolfingrip.sections.laws.law import MaterialLaw
from dolfingrip.sections.lookup import classes

FILES: Final = (
    "neo_hooke",
    "polynomial",
    "ogden",
    "gent",
    "gent_gent",
    "arruda_boyce",
    "extended_tube",
)

LAWS: Final[Mapping[str, type[MaterialLaw]]] = {
    law.law_name(): law
    for law in classes("laws", "dolfingrip.sections.laws", FILES, MaterialLaw).values()
}
"""By ``material.law``; the first is the default."""
