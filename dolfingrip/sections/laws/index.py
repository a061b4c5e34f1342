"""The index of laws of the base material, each the name of its file in this folder."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from dolfingrip.sections.laws.law import MaterialLaw
from dolfingrip.sections.lookup import only_class

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
    for law in (only_class(f"dolfingrip.sections.laws.{file}", MaterialLaw) for file in FILES)
}
"""By ``material.law``; the first is the default."""
