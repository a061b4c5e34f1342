"""The cast block as boxes."""

from __future__ import annotations

from dolfingrip.meshes.boxes import Box, BoxSolid
from dolfingrip.sections.cast import Cast


def box_solid(cast: Cast) -> BoxSolid:
    """The block, its chambers, the tunnel and the tube along the film, and the film."""
    film, roof = cast.film_mm, cast.film_mm + cast.chamber_height_mm
    pitch = cast.chamber_length_mm + cast.spacing
    first = cast.cup_mm + cast.wall_mm
    starts = [first + i * pitch for i in range(cast.chambers)]
    ends = [start + cast.chamber_length_mm for start in starts]
    chamber = (-cast.chamber_width_mm / 2, cast.chamber_width_mm / 2)
    tunnel = (-cast.tunnel_width_mm / 2, cast.tunnel_width_mm / 2)
    across = (-cast.width_mm / 2, cast.width_mm / 2)
    along = (0.0, cast.length_mm)
    cavity: list[Box] = [
        (
            (film, film + cast.tunnel_height_mm),
            tunnel,
            (0.0 if cast.tube else first, ends[-1]),
        ),
        *(((film, roof), chamber, z) for z in zip(starts, ends, strict=True)),
    ]
    return BoxSolid(
        ((0.0, cast.depth_mm), across, along),
        cavity,
        [],
        rising=([film], [chamber[0], tunnel[0]], starts),
        falling=([roof, film + cast.tunnel_height_mm], [chamber[1], tunnel[1]], ends),
        regions={"film": [((0.0, film), across, along)]},
        rest="body",
        cup_mm=cast.cup_mm,
        walls=([film, roof], [*chamber], [*starts, *ends]),
    )
