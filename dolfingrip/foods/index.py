"""The index of the shapes of food, each the name of its file in this folder."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from dolfingrip.foods.kind import FoodKind
from dolfingrip.sections.lookup import only_class

FILES: Final = (
    "sausage",
    "potato",
    "cube",
    "strawberry",
    "stl",
)

SHAPES: Final[tuple[type[FoodKind], ...]] = tuple(
    only_class(f"dolfingrip.foods.{file}", FoodKind) for file in FILES
)

KINDS: Final[Mapping[str, type[FoodKind]]] = {
    kind: shape for shape in SHAPES for kind in shape.portions
}
"""Shapes by ``food.kind``."""
