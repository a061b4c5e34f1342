"""The bellows finger: its dimensions, and the boxes that it is made of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Self

from pydantic import Field

from dolfingrip.sections.geometry.boxes import TOLERANCE_MM, Box, BoxSolid, Interval
from dolfingrip.sections.geometry.geometry import Gaps, Geometry
from dolfingrip.sections.section import Refusal


class Bellows(Geometry):
    """Bellows finger: a base layer at x = 0, clamped at z = 0, bellows towards +x."""

    integration: ClassVar = "reduced"
    tetrahedra: ClassVar = True
    thin: ClassVar = True
    number: ClassVar = "bellows"
    own: ClassVar = ("depth_mm", "gap_mm", "wall_mm", "base_layer_mm", "width_mm")

    length_mm: float = Field(90.0, gt=0, le=1000, description="clamp to tip, along z")
    width_mm: float = Field(20.0, gt=0, le=500, description="along y")
    depth_mm: float = Field(16.0, gt=0, le=500, description="back of base layer to bellows' crown")
    base_layer_mm: float = Field(3.5, gt=0, description="strain-limiting layer")
    wall_mm: float = Field(1.6, gt=0, description="walls of bellows and channel")
    bellows: int = Field(8, ge=1, le=60, description="number of bellows")
    gap_mm: float = Field(2.0, gt=0, description="clear distance between neighbouring bellows")
    channel_mm: float = Field(2.5, gt=0, description="height of the air channel")
    channel_width_mm: float | None = Field(
        None, gt=0, description="width of the air channel; default: as wide as the chambers"
    )
    base_block_mm: float = Field(12.0, gt=0, description="solid block at the clamp")
    tip_mm: float = Field(6.0, gt=0, description="solid tip")
    tube_mm: float = Field(
        0.0,
        ge=0,
        description="square tube from the base layer on through the clamped face; 0: none",
    )

    @property
    def pitch_mm(self) -> float:
        """Distance from one bellows to the next."""
        return (self.length_mm - self.base_block_mm - self.tip_mm) / self.bellows

    @property
    def bellows_mm(self) -> float:
        """Outer length of one bellows along z."""
        return self.pitch_mm - self.gap_mm

    @property
    def chamber_width_mm(self) -> float:
        """Inner width of a bellows along y."""
        return self.width_mm - 2 * self.wall_mm

    @property
    def channel_width(self) -> float:
        """Width of the air channel (mm), the chambers' where none is given."""
        return self.chamber_width_mm if self.channel_width_mm is None else self.channel_width_mm

    @classmethod
    def table(cls) -> str:
        """Name of its table in the configuration, which the mesh's file has, too."""
        return "finger"

    def movable(self, key: str) -> bool:
        """Return whether a mesh can follow a dimension; without a tube that has no face."""
        return key != "tube_mm" or self.tube_mm > 0

    def bellows_intervals(self) -> list[Interval]:
        """Outer extent along z (mm) of each bellows, from clamp to tip.

        The first bellows adjoins the base block; a gap follows each bellows.
        """
        starts = (self.base_block_mm + i * self.pitch_mm for i in range(self.bellows))
        return [(start, start + self.of(i).bellows_mm) for i, start in enumerate(starts)]

    def gap_intervals(self) -> list[Interval]:
        """Extent along z (mm) of the clear spaces that bellows leave between base and tip."""
        bellows = self.bellows_intervals()
        ends = [self.base_block_mm, *(end for _, end in bellows)]
        starts = [*(start for start, _ in bellows), self.length_mm - self.tip_mm]
        pairs = zip(ends, starts, strict=True)
        return [(end, start) for end, start in pairs if start - end > TOLERANCE_MM]

    @property
    def valley_mm(self) -> float:
        """Back of the base layer to the floor of the gaps between bellows."""
        return self.base_layer_mm + self.channel_mm + self.wall_mm

    def solid(self) -> BoxSolid:
        """The body, its channel and chambers, which overlap, and the gaps between bellows."""
        floor, wall, depth = self.base_layer_mm, self.wall_mm, self.depth_mm
        roof, valley = floor + self.channel_mm, self.valley_mm
        bellows = self.bellows_intervals()
        chambers = self.insides(bellows)
        ends = (chambers[0][0], chambers[-1][1])
        across = (-self.width_mm / 2, self.width_mm / 2)
        chamber = (-self.chamber_width_mm / 2, self.chamber_width_mm / 2)
        channel = (-self.channel_width / 2, self.channel_width / 2)
        half = self.tube_mm / 2
        tube: list[Box] = [((floor, floor + self.tube_mm), (-half, half), (0.0, ends[0]))]
        cavity: list[Box] = [
            ((floor, roof), channel, ends),
            *(tube if self.tube_mm else ()),
            *(((floor, depth - wall), chamber, z) for z in chambers),
        ]
        gaps: list[Box] = [((valley, depth), across, z) for z in self.gap_intervals()]
        inner = [chamber[1], channel[1]]
        # inside a cavity and in a gap between bellows, the solid's corners are concave at both ends
        starts, stops = zip(*(box[2] for box in (*cavity, *gaps) if box[2][0]), strict=True)
        return BoxSolid(
            ((0.0, depth), across, (0.0, self.length_mm)),
            cavity,
            gaps,
            rising=([floor, valley], [-y for y in inner], starts),
            falling=([valley], inner, stops),
        )

    def gaps(self) -> Gaps:
        """The gaps between bellows, base block and tip."""
        intervals = self.gap_intervals()
        ends = [end for _, end in self.bellows_intervals()]
        names = [_before(ends, start) for start, _ in intervals]
        every = [section for _, section in self.sections()]
        floor_mm = max(section.valley_mm for section in every)
        return Gaps(intervals, [*names, "tip"], floor_mm, max(section.gap_mm for section in every))

    def sections(self) -> list[tuple[Interval, Self]]:
        """The clamped face, each bellows, and the tip, which has the shared cross-section.

        The first bellows' begins with its chamber, as there is no face where its wall begins.
        """
        alike, (first, *others) = self.alike(), self.bellows_intervals()
        bellows = [(first[0] + self.of(0).wall_mm, first[1]), *others]
        per_bellows = [(z, self.of(i)) for i, z in enumerate(bellows)]
        tip = (self.length_mm - self.tip_mm, self.length_mm)
        return [((0.0, 0.0), alike), *per_bellows, (tip, alike)]

    def distances_mm(self) -> Mapping[str, float]:
        """Least distance of parallel faces by the key that sets it."""
        ledge_mm = self.chamber_width_mm - self.channel_width  # on both sides of the channel
        beside = (self.chamber_width_mm, self.channel_width, self.channel_mm, 0.0)
        apart = [abs(side_mm - self.tube_mm) for side_mm in beside if side_mm != self.tube_mm]
        return {
            **({"tube_mm": min(apart)} if self.tube_mm else {}),
            "length_mm": self.length_mm,
            "base_block_mm": self.base_block_mm,
            "tip_mm": self.tip_mm,
            "base_layer_mm": self.base_layer_mm,
            "gap_mm": self.gap_mm,
            "channel_width_mm": min(self.channel_width, ledge_mm or self.channel_width),
            "channel_mm": min(
                self.channel_mm,
                self.depth_mm - self.base_layer_mm - self.channel_mm - self.wall_mm,
            ),
            "wall_mm": min(self.wall_mm, self.bellows_mm - 2 * self.wall_mm, self.chamber_width_mm),
        }

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        yield from self.below("tip_mm", "length_mm")
        room_mm = self.length_mm - self.tip_mm
        yield from self.below("base_block_mm", room_mm, "leaves no room for bellows; ")
        if self.bellows_mm <= 0:
            words = f"above 0 and below the pitch, {self.pitch_mm:g} mm"
            yield Refusal("gap_mm", f"leaves no bellows; allowed: {words}")
        half_mm = min(self.bellows_mm, self.width_mm, self.depth_mm) / 2
        yield from self.below("wall_mm", half_mm, "thicker than half a bellows; ")
        why = "leaves no room for a bellows above the channel; "
        yield from self.below("base_layer_mm", self.depth_mm - 2 * self.wall_mm, why)
        highest_mm = self.depth_mm - self.base_layer_mm - self.wall_mm
        yield from self.below("channel_mm", highest_mm, "cavity not closed; ")
        if self.tube_mm:
            yield from self.up_to("tube_mm", min(self.chamber_width_mm, highest_mm), "too wide; ")
        if self.channel_width_mm is not None:
            yield from self.up_to("channel_width_mm", self.chamber_width_mm, "cavity not closed; ")


def _before(bellows_ends: list[float], gap_start_mm: float) -> str:
    """Name of the part that ends where a gap starts."""
    ended = sum(end <= gap_start_mm + TOLERANCE_MM for end in bellows_ends)
    return f"bellows {ended}" if ended else "base block"
