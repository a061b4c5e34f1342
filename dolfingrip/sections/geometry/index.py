"""The index of the kinds of geometry: files of this folder, and plugins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.geometry.own import with_own
from dolfingrip.sections.lookup import classes

FILES: Final = (
    "bellows",
    "cast",
    "pneunet",
    "round_bellows",
    "adopted",
)

GEOMETRIES: Final[Mapping[str, type[Geometry]]] = {
    name: with_own(kind)
    for name, kind in classes("geometries", "dolfingrip.sections.geometry", FILES, Geometry).items()
}

NAMES: Final = tuple(GEOMETRIES)
