"""The pneu-net as boxes."""

from __future__ import annotations

from itertools import pairwise

from dolfingrip.meshes.boxes import Box, BoxSolid, Interval
from dolfingrip.sections.pneunet import Pneunet


def chamber_intervals(pneunet: Pneunet) -> list[Interval]:
    """Outer extent along z (mm) of each chamber with its walls."""
    outer = pneunet.chamber_length_mm + 2 * pneunet.wall_mm
    starts = (pneunet.clamp_block_mm + i * pneunet.pitch_mm for i in range(pneunet.chambers))
    return [(start, start + outer) for start in starts]


def valley_mm(pneunet: Pneunet) -> float:
    """Back of the base to the floor of the gaps between chambers."""
    return pneunet.floor_mm + pneunet.tunnel_height_mm + pneunet.roof_mm


def box_solid(pneunet: Pneunet) -> BoxSolid:
    """The block, its chambers and tunnel, the gaps between chambers, base and paper."""
    floor, depth, wall = pneunet.floor_mm, pneunet.depth_mm, pneunet.wall_mm
    roof, valley = floor + pneunet.chamber_height_mm, valley_mm(pneunet)
    outer = chamber_intervals(pneunet)
    inner = [(start + wall, end - wall) for start, end in outer]
    gaps = [(before[1], after[0]) for before, after in pairwise(outer)]
    across = (-pneunet.width_mm / 2, pneunet.width_mm / 2)
    chamber = (-pneunet.chamber_width_mm / 2, pneunet.chamber_width_mm / 2)
    tunnel = (-pneunet.tunnel_width_mm / 2, pneunet.tunnel_width_mm / 2)
    along = (0.0, pneunet.length_mm)
    start = 0.0 if pneunet.tube else inner[0][0]
    cavity: list[Box] = [
        ((floor, floor + pneunet.tunnel_height_mm), tunnel, (start, inner[-1][1])),
        *(((floor, roof), chamber, z) for z in inner),
    ]
    paper = (pneunet.base_mm, pneunet.base_mm + pneunet.paper_mm)
    hollow = [*inner, *gaps]
    return BoxSolid(
        ((0.0, depth), across, along),
        cavity,
        [((valley, depth), across, z) for z in gaps],
        rising=([floor, valley], [chamber[0], tunnel[0]], [low for low, _ in hollow]),
        falling=([valley], [chamber[1], tunnel[1]], [high for _, high in hollow]),
        regions={
            "base": [((0.0, floor), across, along)],
            "paper": [(paper, across, along)],
        },
        rest="body",
    )
