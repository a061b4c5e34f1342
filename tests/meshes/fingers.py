"""Fingers to mesh in tests, and their volumes in closed form."""

from __future__ import annotations

import numpy as np
from pydantic import ValidationError

from dolfingrip.config import Finger
from dolfingrip.meshes.finger import bellows_intervals, gap_intervals


def volumes(finger: Finger) -> tuple[float, float]:
    """Volume of the whole finger's solid and of its cavity, mm³."""
    bellows = bellows_intervals(finger)
    roof = finger.base_layer_mm + finger.channel_mm
    gaps = sum(end - start for start, end in gap_intervals(finger))
    chambers = sum(end - start - 2 * finger.wall_mm for start, end in bellows)
    ends = bellows[0][0] + finger.wall_mm, bellows[-1][1] - finger.wall_mm
    between = ends[1] - ends[0] - chambers
    cavity = (
        chambers
        * finger.chamber_width_mm
        * (finger.depth_mm - finger.wall_mm - finger.base_layer_mm)
        + between * finger.channel_width * finger.channel_mm
    )
    above = finger.depth_mm - roof - finger.wall_mm
    box = finger.depth_mm * finger.width_mm * finger.length_mm
    return box - gaps * finger.width_mm * above - cavity, cavity


def random_finger(rng: np.random.Generator) -> Finger:
    """A finger of possible dimensions, far from the reference."""
    while True:
        try:
            return Finger(
                length_mm=rng.uniform(30, 150),
                width_mm=rng.uniform(8, 40),
                depth_mm=rng.uniform(8, 40),
                base_layer_mm=rng.uniform(0.8, 8),
                wall_mm=rng.uniform(0.5, 4),
                bellows=int(rng.integers(1, 15)),
                gap_mm=rng.uniform(0.5, 6),
                channel_mm=rng.uniform(0.5, 8),
                channel_width_mm=rng.choice([None, rng.uniform(1, 20)]),
                base_block_mm=rng.uniform(1, 30),
                tip_mm=rng.uniform(1, 20),
            )
        except ValidationError:
            continue
