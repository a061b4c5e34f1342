"""The base class of shapes whose distance is sampled on a grid."""

from __future__ import annotations

from pydantic import Field

from dolfingrip.foods.kind import FoodKind


class SampledKind(FoodKind):
    """Food with no distance in closed form."""

    grid_mm: float = Field(
        2.5, gt=0.1, le=20, description="potato, file: spacing of the distance's samples"
    )
