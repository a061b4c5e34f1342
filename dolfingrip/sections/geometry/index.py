"""The index of the kinds of geometry, each the name of its file in this folder."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.geometry.own import with_own
from dolfingrip.sections.lookup import only_class

NAMES: Final = (
    "bellows",
    "cast",
    "pneunet",
    "round_bellows",
    "adopted",
)

GEOMETRIES: Final[Mapping[str, type[Geometry]]] = {
    name: with_own(only_class(f"dolfingrip.sections.geometry.{name}", Geometry)) for name in NAMES
}

TABLES: Final = tuple(geometry.table() for geometry in GEOMETRIES.values())
"""Tables of the configuration with dimensions, one for each kind."""
