"""A pneu-net: chambers with walls of their own on a common base with a layer of paper."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import ClassVar, Self

from pydantic import Field

from dolfingrip.sections.geometry.boxes import THINNEST_MM, Box, BoxSolid, Interval
from dolfingrip.sections.geometry.geometry import Gaps, Geometry, Length
from dolfingrip.sections.section import Refusal


class Pneunet(Geometry):
    """Pneu-net: the base's back at x = 0, clamped at z = 0, chambers towards +x."""

    cast: ClassVar = True
    regions: ClassVar = ("body", "paper", "base")
    limiting: ClassVar = "paper"
    own: ClassVar = (
        *("chamber_length_mm", "chamber_width_mm", "chamber_height_mm"),
        *("wall_mm", "roof_mm", "gap_mm"),
    )

    chambers: int = Field(8, ge=1, le=60, description="number of chambers")
    chamber_length_mm: Length = Field(6.0, description="inside, along z")
    width_mm: Length = Field(20.0, description="of the block, along y")
    chamber_width_mm: Length = Field(16.0, description="inside, along y")
    chamber_height_mm: Length = Field(
        10.0, description="inside, along x, the tunnel's height included"
    )
    wall_mm: Length = Field(1.5, description="walls across z")
    roof_mm: Length = Field(2.0, description="of chambers and tunnel")
    gap_mm: Length = Field(1.0, description="between the chambers' walls")
    tunnel_height_mm: Length = Field(
        2.0, description="of the tunnel that joins the chambers, at base"
    )
    tunnel_width_mm: Length = Field(2.0, description="of that tunnel")
    tube: bool = Field(False, description="the tunnel goes on through the clamped end's face")
    base_mm: Length = Field(2.0, description="base below the paper")
    paper_mm: float = Field(0.2, ge=THINNEST_MM, le=100, description="thickness of the paper")
    cover_mm: float = Field(1.0, ge=0, le=500, description="base between paper and chambers")
    clamp_block_mm: Length = Field(10.0, description="clamp to the first chamber's wall")
    tip_mm: float = Field(2.0, ge=0, le=500, description="last chamber's wall to the tip's face")

    @property
    def floor_mm(self) -> float:
        """Back of the base to the chambers' floor."""
        return self.base_mm + self.paper_mm + self.cover_mm

    @property
    def depth_mm(self) -> float:
        """Back of the base to the chambers' crown."""
        return self.floor_mm + self.chamber_height_mm + self.roof_mm

    @property
    def pitch_mm(self) -> float:
        """Distance from one chamber to the next."""
        return self.chamber_length_mm + 2 * self.wall_mm + self.gap_mm

    @property
    def length_mm(self) -> float:
        """Clamp to tip, along z."""
        chambers = self.chambers * self.pitch_mm - self.gap_mm + self.longer_mm()[-1]
        chambers += self.gap_mm - self.of(self.chambers - 1).gap_mm
        return self.clamp_block_mm + chambers + self.tip_mm

    @property
    def thinnest_mm(self) -> float:
        """Thickness that sizes at concave edges are taken from."""
        return min(self.wall_mm, self.gap_mm)

    @property
    def valley_mm(self) -> float:
        """Back of the base to the floor of the gaps between chambers."""
        return self.floor_mm + self.tunnel_height_mm + self.roof_mm

    def chamber_intervals(self) -> list[Interval]:
        """Outer extent along z (mm) of each chamber with its walls."""
        intervals = []
        for i, longer in enumerate(self.longer_mm()[:-1]):
            start, chamber = self.clamp_block_mm + i * self.pitch_mm + longer, self.of(i)
            intervals.append((start, start + chamber.chamber_length_mm + 2 * chamber.wall_mm))
        return intervals

    def gaps(self) -> Gaps:
        """The gaps between neighbouring chambers."""
        chambers = self.chamber_intervals()
        intervals = [(before[1], after[0]) for before, after in pairwise(chambers)]
        names = [f"chamber {i}" for i in range(1, len(chambers) + 1)]
        every = [section for _, section in self.sections()]
        floor_mm = max(section.valley_mm for section in every)
        return Gaps(intervals, names, floor_mm, max(section.gap_mm for section in every))

    def sections(self) -> list[tuple[Interval, Self]]:
        """The clamped face, and each chamber, the last one with the tip.

        The first chamber's begins inside, as there is no face where its wall begins.
        """
        first, *others = self.chamber_intervals()
        chambers = [(first[0] + self.of(0).wall_mm, first[1]), *others]
        per_chamber = [(z, self.of(i)) for i, z in enumerate(chambers)]
        return [((0.0, 0.0), self.alike()), *per_chamber]

    def solid(self) -> BoxSolid:
        """The block, its chambers and tunnel, the gaps between chambers, base and paper."""
        floor, depth = self.floor_mm, self.depth_mm
        roof, valley = floor + self.chamber_height_mm, self.valley_mm
        outer = self.chamber_intervals()
        inner = self.insides(outer)
        gaps = [(before[1], after[0]) for before, after in pairwise(outer)]
        across = (-self.width_mm / 2, self.width_mm / 2)
        chamber = (-self.chamber_width_mm / 2, self.chamber_width_mm / 2)
        tunnel = (-self.tunnel_width_mm / 2, self.tunnel_width_mm / 2)
        along = (0.0, self.length_mm)
        start = 0.0 if self.tube else inner[0][0]
        cavity: list[Box] = [
            ((floor, floor + self.tunnel_height_mm), tunnel, (start, inner[-1][1])),
            *(((floor, roof), chamber, z) for z in inner),
        ]
        paper = (self.base_mm, self.base_mm + self.paper_mm)
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

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        widest_mm = self.width_mm - 2 * THINNEST_MM
        yield from self.up_to("chamber_width_mm", widest_mm, "wider than the block; ")
        widest_mm = self.chamber_width_mm
        yield from self.up_to("tunnel_width_mm", widest_mm, "wider than the chambers; ")
        highest_mm = self.chamber_height_mm - THINNEST_MM
        why = "cavity not closed between chambers; "
        yield from self.up_to("tunnel_height_mm", highest_mm, why)
        for key in ("cover_mm", "tip_mm"):
            if 0 < getattr(self, key) < THINNEST_MM:
                yield Refusal(key, f"allowed: 0, or at least {THINNEST_MM} mm")
