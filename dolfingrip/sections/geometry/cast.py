"""A cast block: chambers open to one side, where a film closes them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from pydantic import Field

from dolfingrip.sections.geometry.boxes import THINNEST_MM, Box, BoxSolid
from dolfingrip.sections.geometry.geometry import Geometry, Length
from dolfingrip.sections.section import Refusal


class Cast(Geometry):
    """Cast block: the film's back at x = 0, clamped at z = 0, chambers open to the film."""

    cast: ClassVar = True
    regions: ClassVar = ("body", "film")
    limiting: ClassVar = "film"

    chambers: int = Field(5, ge=1, le=60, description="number of chambers")
    chamber_height_mm: Length = Field(8.0, description="from the film, on x")
    chamber_width_mm: Length = Field(8.0, description="along y")
    chamber_length_mm: Length = Field(2.0, description="along z")
    wall_mm: Length = Field(7.0, description="roof, sides and ends")
    spacing_mm: float | None = Field(
        None,
        ge=THINNEST_MM,
        le=500,
        description="wall between two chambers; default: as thick as the others",
    )
    tunnel_height_mm: Length = Field(
        2.0, description="of the tunnel that joins the chambers, at film"
    )
    tunnel_width_mm: Length = Field(2.0, description="of that tunnel")
    tube: bool = Field(True, description="the tunnel goes on through the clamped end's face")
    film_mm: float = Field(0.5, ge=THINNEST_MM, le=100, description="thickness of the film")
    cup_mm: float = Field(
        0.0, ge=0, le=500, description="further length at the clamped end, held on all sides"
    )

    @property
    def spacing(self) -> float:
        """Wall between two chambers (mm)."""
        return self.wall_mm if self.spacing_mm is None else self.spacing_mm

    @property
    def length_mm(self) -> float:
        """Clamp to tip, along z."""
        walls = 2 * self.wall_mm + (self.chambers - 1) * self.spacing
        return self.cup_mm + self.chambers * self.chamber_length_mm + walls

    @property
    def width_mm(self) -> float:
        """Outer width along y."""
        return self.chamber_width_mm + 2 * self.wall_mm

    @property
    def depth_mm(self) -> float:
        """The film's back to the roof's, along x."""
        return self.film_mm + self.chamber_height_mm + self.wall_mm

    @property
    def thinnest_mm(self) -> float:
        """Thickness that sizes at concave edges are taken from."""
        return min(self.wall_mm, self.chamber_length_mm)

    def movable(self, key: str) -> bool:
        """Return whether a mesh can follow a dimension; without a cup that has no face."""
        return key != "cup_mm" or self.cup_mm > 0

    def solid(self) -> BoxSolid:
        """The block, its chambers, the tunnel and the tube along the film, and the film."""
        film, roof = self.film_mm, self.film_mm + self.chamber_height_mm
        pitch = self.chamber_length_mm + self.spacing
        first = self.cup_mm + self.wall_mm
        starts = [first + i * pitch for i in range(self.chambers)]
        ends = [start + self.chamber_length_mm for start in starts]
        chamber = (-self.chamber_width_mm / 2, self.chamber_width_mm / 2)
        tunnel = (-self.tunnel_width_mm / 2, self.tunnel_width_mm / 2)
        across = (-self.width_mm / 2, self.width_mm / 2)
        along = (0.0, self.length_mm)
        cavity: list[Box] = [
            (
                (film, film + self.tunnel_height_mm),
                tunnel,
                (0.0 if self.tube else first, ends[-1]),
            ),
            *(((film, roof), chamber, z) for z in zip(starts, ends, strict=True)),
        ]
        return BoxSolid(
            ((0.0, self.depth_mm), across, along),
            cavity,
            [],
            rising=([film], [chamber[0], tunnel[0]], starts),
            falling=([roof, film + self.tunnel_height_mm], [chamber[1], tunnel[1]], ends),
            regions={"film": [((0.0, film), across, along)]},
            rest="body",
            cup_mm=self.cup_mm,
            walls=([film, roof], [*chamber], [*starts, *ends]),
        )

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        yield from self.up_to("tunnel_height_mm", "chamber_height_mm")
        yield from self.up_to("tunnel_width_mm", "chamber_width_mm")
        if 0 < self.cup_mm < THINNEST_MM:
            yield Refusal("cup_mm", f"allowed: 0, or at least {THINNEST_MM} mm")
