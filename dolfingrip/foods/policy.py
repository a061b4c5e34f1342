"""The numbers that the shape of food rests on."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FoodShape:
    """How finely the shape of food is represented, and how it may be put down.

    Attributes:
        margin_cells: cells of a sampled distance beyond the shape: what the grid's end disturbs is
            not felt.
        divisions: points of a skin along half of a body.
        least_spacing_mm: least distance of these points.
        largest_spacing_mm: largest distance of these points.
        tipped_deg: how far a body that does not lie still as it is drawn may turn to where it does.
        even_mm: difference of a shape from its mirror image that is not felt: a part of the
            barrier's width.
    """

    margin_cells: float = 4.0
    divisions: int = 15
    least_spacing_mm: float = 1.0
    largest_spacing_mm: float = 4.0
    tipped_deg: float = 40.0
    even_mm: float = 0.01


FOOD_SHAPE = FoodShape()
