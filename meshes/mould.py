"""The mould of a cast finger: two halves, a plate with the cores, and a tray for the base."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import gmsh

from dolfingrip.meshes.gmsh_model import Solids, brick, common, fused, less, tapered
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.geometry.boxes import Box, BoxSolid
from dolfingrip.sections.making import Mould

RIM_WALLS: Final = 2.0
"""Height of the plate's rim around the halves, by the thickness of the mould's walls."""

COMES_OFF: Final = {
    "core_plate": (-1.0, 0.0, 0.0),
    "half_1": (0.0, -1.0, 0.0),
    "half_2": (0.0, 1.0, 0.0),
    "base_tray": (-1.0, 0.0, 0.0),
}
"""Parts in the order in which they come off the cast, and the direction in which each is pulled.

The plate is first, as its rim holds the halves and its cores reach between them.
"""


@dataclass(frozen=True, slots=True)
class Moulded:
    """A mould and what is cast in it, as solids of the current Gmsh model.

    Attributes:
        parts: the mould's parts by name, which are printed.
        body: the silicone between the halves and the cores, poured from the crown's side.
        base: what fills the tray.
    """

    parts: dict[str, Solids]
    body: Solids
    base: Solids


def add_mould(shape: BoxSolid, mould: Mould) -> Moulded:
    """Add the mould of a cast finger and its casts to the current Gmsh model.

    The halves stand on the plate, in whose rim they lie, and leave the crown's side open. They are
    pulled off along y, out of the gaps, after the plate was pulled off along −x.

    Args:
        shape: the finger; all its hollows begin in one plane across x, where its body ends and
            its base begins.
        mould: walls, draft, place of the split, and clearance.

    Raises:
        ConfigError: one line, if the halves cannot meet where they are asked to.
    """
    floor = min(box[0][0] for box in shape.cavity)
    (_, depth), across, along = shape.body
    if not across[0] < mould.split_mm < across[1]:
        raise ConfigError(
            f"mould.split_mm = {mould.split_mm:g}: beside the finger; allowed: above "
            f"{across[0]:g} mm and below {across[1]:g} mm"
        )
    wall, slope = mould.thickness_mm, math.tan(math.radians(mould.draft_deg))
    frame: Box = ((floor, depth), _grown(across, wall), _grown(along, wall))
    above = _grown((floor, depth), wall)  # what is cut at both ends has no taper there
    sides = ((0, (across[0], mould.split_mm)), (1, (mould.split_mm, across[1])))

    # halves are pulled off along y: hollows in them shrink away from the split, fins towards it
    first, second = (tapered((above, y, along), 1, 1 - side, slope) for side, y in sides)
    fins = [
        fin
        for x, _, z in shape.gaps
        for side, y in sides
        for fin in tapered(((x[0], above[1]), y, z), 1, side, slope)
    ]
    outer = less(common(fused(first, second), brick(frame)), fins)
    cores = [core for box in shape.cavity for core in tapered(_led_out(box, wall), 0, 0, slope)]
    cores = common(fused(cores[:1], cores[1:]), outer)
    round_it = [_grown(extent, mould.clearance_mm) for extent in frame[1:]]
    plate: Box = (
        (floor - wall, floor), _grown(round_it[0], wall), _grown(round_it[1], wall)
    )  # fmt: skip
    rim = less(
        brick(((floor, floor + RIM_WALLS * wall), *plate[1:])),
        brick(((floor, floor + RIM_WALLS * wall), round_it[0], round_it[1])),
    )
    block = less(brick(frame), outer, keep=True)
    far = _grown(across, 2 * wall)
    halves = [
        common(gmsh.model.occ.copy(block), brick((frame[0], y, frame[2])))
        for y in ((far[0], mould.split_mm), (mould.split_mm, far[1]))
    ]
    body = less(outer, cores, keep=True)
    base = tapered(((0.0, floor), across, along), 0, 1, slope)
    tray = less(brick(((-wall, floor), frame[1], frame[2])), base, keep=True)
    parts = {
        "half_1": halves[0],
        "half_2": halves[1],
        "core_plate": fused(brick(plate), [*rim, *cores]),
        "base_tray": tray,
    }
    gmsh.model.occ.synchronize()
    return Moulded(parts, body, base)


def _grown(interval: tuple[float, float], by: float) -> tuple[float, float]:
    return interval[0] - by, interval[1] + by


def _led_out(box: Box, by: float) -> Box:
    """A hollow that is longer where it ends in the clamped face, so that no taper closes it."""
    x, y, z = box
    return (x, y, (z[0] - by, z[1])) if z[0] <= 0 else box
