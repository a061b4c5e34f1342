"""The skin of food from its signed distance, and the distance of a closed surface."""

from __future__ import annotations

import numpy as np

from dolfingrip.foods.policy import FOOD_SHAPE
from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.meshes.closed_surface import ClosedSurface, level_set


def skin_of(shape: SignedDistance, half_mm: np.ndarray) -> ClosedSurface:
    """Zeros of a distance within a box about the origin, in triangles fit for its size."""
    size_mm = half_mm.prod() ** (1 / 3)
    spacing_mm = float(
        np.clip(
            size_mm / FOOD_SHAPE.divisions,
            FOOD_SHAPE.least_spacing_mm,
            FOOD_SHAPE.largest_spacing_mm,
        )
    )

    def found(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        distances = shape.at(points)
        return distances.value, distances.gradient

    # off the grid's planes, lest they lie in a flat face
    reach = half_mm + 1.37 * spacing_mm
    return level_set(found, -reach, reach, spacing_mm)


def sampled(
    source: ClosedSurface, grid_mm: float, smoothing_mm: float = 0.0
) -> tuple[SignedDistance, ClosedSurface]:
    """Distance of a surface as sampled on a grid, and the skin on its zeros.

    Args:
        source: the surface, anywhere.
        grid_mm: spacing of the samples.
        smoothing_mm: standard deviation that rounds its edges off.
    """
    from dolfingrip.mechanics.contact.sampled_distance import SampledDistance

    source = source.moved(-source.centre_mm)
    beyond = FOOD_SHAPE.margin_cells * grid_mm + smoothing_mm
    low, high = source.points.min(axis=0) - beyond, source.points.max(axis=0) + beyond
    found = SampledDistance.of(source.distances_mm, low, high, grid_mm, smoothing_mm)
    return found, skin_of(found, np.maximum(-low, high) - grid_mm)
