"""The clear spaces between neighbouring bellows or chambers, and the names of what they part."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from dolfingrip.meshes.boxes import TOLERANCE_MM, Interval
from dolfingrip.meshes.finger import bellows_intervals, gap_intervals
from dolfingrip.meshes.kinds import Dimensions
from dolfingrip.meshes.pneunet import chamber_intervals, valley_mm
from dolfingrip.sections.pneunet import Pneunet
from dolfingrip.sections.specimen import Finger


@dataclass(frozen=True, slots=True)
class Gaps:
    """Gaps along a finger.

    Attributes:
        intervals: extent along z (mm) of each gap, from clamp to tip.
        parts: names of what the gaps part, one more than there are gaps.
        floor_mm: height x of the gaps' floors.
        width_mm: clear distance.
        depth_mm: height x of the finger's crown.
    """

    intervals: list[Interval]
    parts: list[str]
    floor_mm: float
    width_mm: float
    depth_mm: float


def gaps_of(dimensions: Dimensions) -> Gaps:
    """The gaps of a geometry, none of a solid block."""
    if isinstance(dimensions, Finger):
        found = gap_intervals(dimensions)
        ends = [end for _, end in bellows_intervals(dimensions)]
        names = [_before(ends, start) for start, _ in found]
        floor = dimensions.base_layer_mm + dimensions.channel_mm + dimensions.wall_mm
        return Gaps(found, [*names, "tip"], floor, dimensions.gap_mm, dimensions.depth_mm)
    if isinstance(dimensions, Pneunet):
        chambers = chamber_intervals(dimensions)
        found = [(before[1], after[0]) for before, after in pairwise(chambers)]
        names = [f"chamber {i}" for i in range(1, len(chambers) + 1)]
        floor = valley_mm(dimensions)
        return Gaps(found, names, floor, dimensions.gap_mm, dimensions.depth_mm)
    return Gaps([], [], 0.0, 0.0, dimensions.depth_mm)


def _before(bellows_ends: list[float], gap_start_mm: float) -> str:
    """Name of the part that ends where a gap starts."""
    ended = sum(end <= gap_start_mm + TOLERANCE_MM for end in bellows_ends)
    return f"bellows {ended}" if ended else "base block"
