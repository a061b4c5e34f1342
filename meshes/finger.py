"""The bellows finger as boxes.

The base layer's back is the plane x = 0, the clamp z = 0, the symmetry plane y = 0.
"""

from __future__ import annotations

from dolfingrip.meshes.boxes import THINNEST_MM, TOLERANCE_MM, Box, BoxSolid
from dolfingrip.meshes.solid import MeshError
from dolfingrip.sections.specimen import Finger


def bellows_intervals(finger: Finger) -> list[tuple[float, float]]:
    """Outer extent along z (mm) of each bellows, from clamp to tip.

    The first bellows adjoins the base block; a gap follows each bellows.
    """
    starts = (finger.base_block_mm + i * finger.pitch_mm for i in range(finger.bellows))
    return [(start, start + finger.bellows_mm) for start in starts]


def gap_intervals(finger: Finger) -> list[tuple[float, float]]:
    """Extent along z (mm) of the clear spaces that the bellows leave between base and tip."""
    bellows = bellows_intervals(finger)
    ends = [finger.base_block_mm, *(end for _, end in bellows)]
    starts = [*(start for start, _ in bellows), finger.length_mm - finger.tip_mm]
    pairs = zip(ends, starts, strict=True)
    return [(end, start) for end, start in pairs if start - end > TOLERANCE_MM]


def boxes(finger: Finger) -> tuple[Box, list[Box], list[Box]]:
    """The finger's body, its cavity (chambers and channel) and the gaps between its bellows.

    Returns:
        The body; the cavity's boxes, which overlap; the gaps. A box is its extent (mm) along x, y
        and z.
    """
    floor, wall, depth = finger.base_layer_mm, finger.wall_mm, finger.depth_mm
    roof = floor + finger.channel_mm
    bellows = bellows_intervals(finger)
    ends = (bellows[0][0] + wall, bellows[-1][1] - wall)
    across = (-finger.width_mm / 2, finger.width_mm / 2)
    chamber = (-finger.chamber_width_mm / 2, finger.chamber_width_mm / 2)
    channel = (-finger.channel_width / 2, finger.channel_width / 2)
    cavity = [
        ((floor, depth - wall), chamber, (start + wall, end - wall)) for start, end in bellows
    ]
    return (
        ((0.0, depth), across, (0.0, finger.length_mm)),
        [((floor, roof), channel, ends), *cavity],
        [((roof + wall, depth), across, z) for z in gap_intervals(finger)],
    )


def box_solid(finger: Finger) -> BoxSolid:
    """The finger as a solid of boxes."""
    body, cavity, gaps = boxes(finger)
    floor = finger.base_layer_mm
    valley = floor + finger.channel_mm + finger.wall_mm
    inner = [finger.chamber_width_mm / 2, finger.channel_width / 2]
    # inside a cavity and in a gap between bellows, the solid's corners are concave at both ends
    starts, ends = zip(*(box[2] for box in (*cavity, *gaps)), strict=True)
    return BoxSolid(
        body,
        cavity,
        gaps,
        rising=([floor, valley], [-y for y in inner], starts),
        falling=([valley], inner, ends),
    )


def refuse_slivers(finger: Finger) -> None:
    """Refuse dimensions that leave faces closer than :data:`THINNEST_MM`.

    Raises:
        MeshError: one line naming the dimension.
    """
    beside = finger.chamber_width_mm - finger.channel_width
    distances = {
        "length_mm": finger.length_mm,
        "base_block_mm": finger.base_block_mm,
        "tip_mm": finger.tip_mm,
        "base_layer_mm": finger.base_layer_mm,
        "gap_mm": finger.gap_mm,
        "channel_width_mm": min(finger.channel_width, beside or finger.channel_width),
        "channel_mm": min(
            finger.channel_mm,
            finger.depth_mm - finger.base_layer_mm - finger.channel_mm - finger.wall_mm,
        ),
        "wall_mm": min(
            finger.wall_mm, finger.bellows_mm - 2 * finger.wall_mm, finger.chamber_width_mm
        ),
    }
    for key, distance in distances.items():
        if distance < THINNEST_MM:
            raise MeshError(
                f"finger.{key} = {getattr(finger, key)}: leaves {distance:.3g} mm between two "
                f"faces; allowed: at least {THINNEST_MM} mm"
            )
