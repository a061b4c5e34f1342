"""The index of the shapes of food: files of this folder, and plugins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from dolfingrip.foods.kind import FoodKind
from dolfingrip.sections.lookup import classes

FILES: Final = (
    "sausage",
    "potato",
    "cube",
    "strawberry",
    "stl",
)

SHAPES: Final[tuple[type[FoodKind], ...]] = tuple(
    classes("foods", "dolfingrip.foods", FILES, FoodKind).values()
)

KINDS: Final[Mapping[str, type[FoodKind]]] = {
    kind: shape for shape in SHAPES for kind in shape.portions
}
"""Shapes by ``food.kind``."""
