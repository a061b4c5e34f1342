"""The skin of food from its signed distance, and the distance of a closed surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.meshes.closed_surface import ClosedSurface, level_set


@dataclass(frozen=True, slots=True)
class SkinPolicy:
    """How finely the shape of food is represented.

    Attributes:
        margin_cells: cells of a sampled distance beyond the shape: what the grid's end disturbs is
            not felt.
        divisions: points of a skin along half of a body.
        least_spacing_mm: least distance of these points.
        largest_spacing_mm: largest distance of these points.
    """

    margin_cells: float = 4.0
    divisions: int = 15
    least_spacing_mm: float = 1.0
    largest_spacing_mm: float = 4.0


def skin_of(
    shape: SignedDistance, half_mm: np.ndarray, policy: SkinPolicy = SkinPolicy()
) -> ClosedSurface:
    """Zeros of a distance within a box about the origin, in triangles fit for its size."""
    size_mm = half_mm.prod() ** (1 / 3)
    spacing_mm = float(
        np.clip(size_mm / policy.divisions, policy.least_spacing_mm, policy.largest_spacing_mm)
    )

    def found(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        distances = shape.at(points)
        return distances.value, distances.gradient

    # off the grid's planes, lest they lie in a flat face
    reach = half_mm + 1.37 * spacing_mm
    return level_set(found, -reach, reach, spacing_mm)


def sampled(
    source: ClosedSurface,
    grid_mm: float,
    smoothing_mm: float = 0.0,
    policy: SkinPolicy = SkinPolicy(),
) -> tuple[SignedDistance, ClosedSurface]:
    """Distance of a surface as sampled on a grid, and the skin on its zeros.

    Args:
        source: the surface, anywhere.
        grid_mm: spacing of the samples.
        smoothing_mm: standard deviation that rounds its edges off.
        policy: how finely it is represented.
    """
    from dolfingrip.mechanics.contact.sampled_distance import SampledDistance

    source = source.moved(-source.centre_mm)
    beyond = policy.margin_cells * grid_mm + smoothing_mm
    low, high = source.points.min(axis=0) - beyond, source.points.max(axis=0) + beyond
    found = SampledDistance.of(source.distances_mm, low, high, grid_mm, smoothing_mm)
    return found, skin_of(found, np.maximum(-low, high) - grid_mm)
