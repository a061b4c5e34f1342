"""The skin of food from its signed distance, and the distance of a closed surface."""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.meshes.closed_surface import ClosedSurface, level_set

MARGIN_CELLS: Final = 4.0
"""Cells of a sampled distance beyond the shape: what the grid's end disturbs is not felt."""

DIVISIONS: Final = 15
"""Points of a skin along half of a body."""

LEAST_SPACING_MM: Final = 1.0
"""Least distance of these points."""

LARGEST_SPACING_MM: Final = 4.0
"""Largest distance of these points."""


def skin_of(shape: SignedDistance, half_mm: np.ndarray) -> ClosedSurface:
    """Zeros of a distance within a box about the origin, in triangles fit for its size."""
    size_mm = half_mm.prod() ** (1 / 3)
    spacing_mm = float(np.clip(size_mm / DIVISIONS, LEAST_SPACING_MM, LARGEST_SPACING_MM))

    def distance_and_gradient(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        distances = shape.at(points)
        return distances.value, distances.gradient

    # off the grid's planes, lest they lie in a flat face
    reach = half_mm + 1.37 * spacing_mm
    return level_set(distance_and_gradient, -reach, reach, spacing_mm)


def sampled(
    source: ClosedSurface,
    grid_mm: float,
    smoothing_mm: float = 0.0,
) -> tuple[SignedDistance, ClosedSurface]:
    """Distance of a surface as sampled on a grid, and the skin on its zeros.

    Args:
        source: the surface, anywhere.
        grid_mm: spacing of the samples.
        smoothing_mm: standard deviation that rounds its edges off.
    """
    from dolfingrip.mechanics.contact.sampled_distance import SampledDistance

    source = source.moved(-source.centre_mm)
    beyond = MARGIN_CELLS * grid_mm + smoothing_mm
    low, high = source.points.min(axis=0) - beyond, source.points.max(axis=0) + beyond
    distance = SampledDistance.of(source.distances_mm, low, high, grid_mm, smoothing_mm)
    return distance, skin_of(distance, np.maximum(-low, high) - grid_mm)
