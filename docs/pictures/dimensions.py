"""Drawings of each kind of geometry with the key of the configuration at each dimension.

    scripts/run python docs/pictures/dimensions.py

draws ``docs/dimensions_KIND.png`` from the solids that the mesh generator takes. Few chambers are
drawn, so that each dimension has room.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from dolfingrip import config
from dolfingrip.charts import theme
from dolfingrip.config import Change
from dolfingrip.sections.geometry.bellows import Bellows
from dolfingrip.sections.geometry.boxes import Box, BoxSolid, CylinderSolid
from dolfingrip.sections.geometry.cast import Cast
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.geometry.pneunet import Pneunet
from dolfingrip.sections.geometry.round_bellows import RoundBellows

HERE = Path(__file__).resolve().parent
BODY, AIR, FILM = theme.PLAIN, "white", theme.ORANGE
ARROW = {"arrowstyle": "<|-|>", "color": theme.INK, "lw": 0.7, "shrinkA": 0, "shrinkB": 0,
         "mutation_scale": 6}  # fmt: skip
INWARD = {**ARROW, "arrowstyle": "-|>"}
SHORT_MM = 4.0
"""Below this the arrows point at a dimension from outside."""

PLANE = "plane of symmetry, y = 0"

Point = tuple[float, float]


class Dimension(NamedTuple):
    """A dimension in a drawing; points are across and up, in mm.

    Attributes:
        key: written at it.
        start, end: of the arrow.
        text: place of the key; None: amid the arrow, on top of it.
    """

    key: str
    start: Point
    end: Point
    text: Point | None = None


def rectangles(axes: Axes, boxes: Iterable[Box], across: int, up: int, colour: str) -> None:
    """Fill boxes as they are seen along the third axis."""
    for box in boxes:
        (left, right), (low, high) = box[across], box[up]
        axes.add_patch(Rectangle((left, low), right - left, high - low, fc=colour, ec="none"))


def outline(axes: Axes, boxes: Iterable[Box], across: int, up: int) -> None:
    """Draw the edges of boxes."""
    for box in boxes:
        (left, right), (low, high) = box[across], box[up]
        axes.add_patch(
            Rectangle((left, low), right - left, high - low, fill=False, ec=theme.INK, lw=0.4)
        )


def draw(axes: Axes, dimensions: Sequence[Dimension]) -> None:
    """Draw arrows, with their keys."""
    for key, start, end, text in dimensions:
        upright = start[0] == end[0]
        length = abs(end[0] - start[0]) + abs(end[1] - start[1])
        if length < SHORT_MM:
            step = (0.0, 2.2) if upright else (2.2, 0.0)
            for tip, sign in ((start, -1), (end, 1)):
                tail = (tip[0] + sign * step[0], tip[1] + sign * step[1])
                axes.annotate("", tip, tail, arrowprops=INWARD)
        else:
            axes.annotate("", end, start, arrowprops=ARROW)
        middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        style = {"family": "monospace", "fontsize": 6.5, "color": theme.INK}
        if text is None:
            turn = {"rotation": 90, "ha": "right", "va": "center"} if upright else {
                "ha": "center", "va": "bottom"}  # fmt: skip
            axes.annotate(key, middle, (-1, 0) if upright else (0, 1),
                          textcoords="offset points", **style, **turn)  # fmt: skip
        else:
            axes.annotate(
                key, middle, text, ha="center", va="center", **style,
                arrowprops={"arrowstyle": "-", "color": theme.GREY, "lw": 0.5, "shrinkB": 0},
            )  # fmt: skip


def extend(axes: Axes, lines: Iterable[tuple[Point, Point]]) -> None:
    """Draw extension lines of dimensions that stand beside the body."""
    for start, end in lines:
        axes.plot(*zip(start, end, strict=True), color=theme.GREY, lw=0.4)


def boxes(axes: Axes, solid: BoxSolid, across: int, up: int, at: float) -> None:
    """Draw a section through a solid of boxes, at a coordinate along the third axis."""
    through = ({0, 1, 2} - {across, up}).pop()

    def cut(all_boxes: Iterable[Box]) -> list[Box]:
        return [box for box in all_boxes if box[through][0] < at < box[through][1]]

    rectangles(axes, [solid.body], across, up, BODY)
    for name, parts in solid.regions.items():
        colour = FILM if name in ("film", "paper") else "#B7D3E8"
        rectangles(axes, cut(parts), across, up, colour)
    for hollows in (solid.gaps, solid.cavity):
        rectangles(axes, cut(hollows), across, up, AIR)


def page(panels: Sequence[tuple[str, float, float, float, float]],
         width_in: float = 7.6) -> list[Axes]:  # fmt: skip
    """Panels of one scale side by side: title, lowest and highest coordinate across and up."""
    theme.figure_theme().__enter__()
    wide = [right - left for _, left, right, _, _ in panels]
    tall = max(high - low for *_, low, high in panels)
    _, axes = plt.subplots(
        1, len(panels), figsize=(width_in, width_in * tall / sum(wide) + 0.3), width_ratios=wide,
        layout="constrained",
    )  # fmt: skip
    for each, (title, left, right, low, high) in zip(axes, panels, strict=True):
        each.set(xlim=(left, right), ylim=(low, high), aspect="equal")
        each.axis("off")
        each.set_title(title, fontsize=7.5)
    return list(axes)


def save(axes: Sequence[Axes], name: str) -> None:
    """Write a drawing."""
    path = HERE.parent / f"dimensions_{name}.png"
    axes[0].figure.savefig(path, dpi=200)
    plt.close(axes[0].figure)
    print(f"wrote {path}")


def geometry(change: Change) -> Geometry:
    """The geometry of a changed default configuration."""
    return config.load(None, change).geometry


def bellows() -> None:
    """The printed finger: section in the plane of symmetry, and across a bellows."""
    finger = geometry({"finger.bellows": 4, "finger.length_mm": 58.0, "finger.tube_mm": 1.5,
                       "finger.channel_width_mm": 10.0})  # fmt: skip
    assert isinstance(finger, Bellows)
    length, depth, floor = finger.length_mm, finger.depth_mm, finger.base_layer_mm
    first, second, third, last = finger.bellows_intervals()
    roof = floor + finger.channel_mm
    along, across = page([(f"{PLANE}; bellows = 4", -9, length + 9, -13, depth + 12),
                          ("across a bellows", -18, 18, -13, depth + 12)])  # fmt: skip
    solid = finger.solid()
    boxes(along, solid, 2, 0, 0.01)
    extend(along, [((z, 0), (z, -9.5)) for z in (0, length)])
    extend(along, [((z, 0), (z, -4)) for z in (finger.base_block_mm, length - finger.tip_mm)])
    extend(along, [((length, x), (length + 6, x)) for x in (0, depth)])
    amid = (second[0] + second[1]) / 2
    draw(along, [
        Dimension("length_mm", (0, -9), (length, -9)),
        Dimension("base_block_mm", (0, -3.5), (finger.base_block_mm, -3.5), (8, -6.2)),
        Dimension("tip_mm", (length - finger.tip_mm, -3.5), (length, -3.5), (length - 4, -6.2)),
        Dimension("depth_mm", (length + 5.5, 0), (length + 5.5, depth)),
        Dimension("base_layer_mm", (amid, 0), (amid, floor), (amid + 4, -6.2)),
        Dimension("channel_mm", (first[1] + 1, floor), (first[1] + 1, roof), (14, depth + 9.5)),
        Dimension("gap_mm", (second[1], depth - 3), (third[0], depth - 3), (34, depth + 9.5)),
        Dimension("wall_mm", (amid, depth - finger.wall_mm), (amid, depth), (24.5, depth + 6)),
        Dimension("wall_mm", (last[0], depth - 6), (last[0] + finger.wall_mm, depth - 6),
                  (46, depth + 6)),
        Dimension("tube_mm", (4, floor), (4, floor + finger.tube_mm), (2, depth + 6)),
    ])  # fmt: skip
    along.annotate("clamp", (0, depth / 2), (-3, 0), textcoords="offset points", rotation=90,
                   ha="right", va="center", fontsize=7)  # fmt: skip
    boxes(across, solid, 1, 0, amid)
    half, channel = finger.width_mm / 2, finger.channel_width / 2
    extend(across, [((y, 0), (y, -9.5)) for y in (-half, half)])
    draw(across, [
        Dimension("width_mm", (-half, -9), (half, -9)),
        Dimension("wall_mm", (-half, depth - 5), (finger.wall_mm - half, depth - 5),
                  (-11, depth + 6)),
        Dimension("channel_width_mm", (-channel, (floor + roof) / 2), (channel, (floor + roof) / 2),
                  (0, -4.5)),
    ])  # fmt: skip
    across.plot([-channel, -channel, channel, channel], [roof, floor, floor, roof], "--",
                color=theme.GREY, lw=0.6)  # fmt: skip
    save([along, across], "bellows")


def cast() -> None:
    """The cast block: section in the plane of symmetry, and across a chamber."""
    block = geometry({"finger.kind": "cast", "cast.chambers": 3, "cast.cup_mm": 5.0})
    assert isinstance(block, Cast)
    length, depth, film = block.length_mm, block.depth_mm, block.film_mm
    starts = [block.cup_mm + block.wall_mm + i * (block.chamber_length_mm + block.spacing)
              for i in range(3)]  # fmt: skip
    ends = [start + block.chamber_length_mm for start in starts]
    roof = film + block.chamber_height_mm
    along, across = page([(f"{PLANE}; chambers = 3", -9, length + 8, -13, depth + 10),
                          ("across a chamber", -16, 16, -13, depth + 10)])  # fmt: skip
    solid = block.solid()
    boxes(along, solid, 2, 0, 0.01)
    extend(along, [((block.cup_mm, x), (block.cup_mm, -4)) for x in (0,)])
    extend(along, [((length, x), (length + 5, x)) for x in (0, film)])
    high, low = depth - 3.5, film + block.tunnel_height_mm
    draw(along, [
        Dimension("cup_mm", (0, -3.5), (block.cup_mm, -3.5), (2.5, -6.5)),
        Dimension("wall_mm", (block.cup_mm, 6), (starts[0], 6), (8.5, depth + 4)),
        Dimension("wall_mm", (starts[2] + 1, roof), (starts[2] + 1, depth), (38, depth + 4)),
        Dimension("spacing_mm", (ends[0], 6), (starts[1], 6), (19, depth + 7.5)),
        Dimension("chamber_length_mm", (starts[1], high - 4.5), (ends[1], high - 4.5),
                  (27, depth + 4)),
        Dimension("chamber_height_mm", (starts[2] + 1, film), (starts[2] + 1, roof),
                  (length - 4, -9.5)),
        Dimension("tunnel_height_mm", (ends[1] + 3, film), (ends[1] + 3, low), (20, -9.5)),
        Dimension("film_mm", (length + 3, 0), (length + 3, film), (length + 2, -5.5)),
    ])  # fmt: skip
    along.text(1.0, film + 2.6, "tube", fontsize=6.5, family="monospace")
    along.annotate("clamp", (0, depth / 2), (-3, 0), textcoords="offset points", rotation=90,
                   ha="right", va="center", fontsize=7)  # fmt: skip
    boxes(across, solid, 1, 0, (starts[1] + ends[1]) / 2)
    wide, tunnel, half = block.chamber_width_mm / 2, block.tunnel_width_mm / 2, block.width_mm / 2
    across.plot([-tunnel, -tunnel, tunnel, tunnel], [film, low, low, film], "--", color=theme.GREY,
                lw=0.6)  # fmt: skip
    draw(across, [
        Dimension("chamber_width_mm", (-wide, roof - 1.5), (wide, roof - 1.5), (0, depth + 4)),
        Dimension("tunnel_width_mm", (-tunnel, film + 1), (tunnel, film + 1), (0, -5)),
        Dimension("wall_mm", (wide, film + 4), (half, film + 4)),
    ])  # fmt: skip
    save([along, across], "cast")


def pneunet() -> None:
    """The pneu-net: section in the plane of symmetry, and across a chamber."""
    body = geometry({"finger.kind": "pneunet", "pneunet.chambers": 4, "pneunet.gap_mm": 2.0,
                     "pneunet.paper_mm": 0.6, "pneunet.tip_mm": 4.0})  # fmt: skip
    assert isinstance(body, Pneunet)
    length, depth, floor = body.length_mm, body.depth_mm, body.floor_mm
    outer = body.chamber_intervals()
    paper = body.base_mm + body.paper_mm
    inside = [(low + body.wall_mm, high - body.wall_mm) for low, high in outer]
    amid = sum(inside[1]) / 2
    along, across = page([(f"{PLANE}; chambers = 4", -6, length + 13, -13, depth + 10),
                          ("across a chamber", -16, 16, -13, depth + 10)])  # fmt: skip
    solid = body.solid()
    boxes(along, solid, 2, 0, 0.01)
    extend(along, [((z, 0), (z, -4)) for z in (0, body.clamp_block_mm, outer[3][1], length)])
    extend(along, [((length, x), (length + 5, x)) for x in (0, body.base_mm, paper, floor)])
    tunnel = floor + body.tunnel_height_mm
    roof = floor + body.chamber_height_mm
    draw(along, [
        Dimension("clamp_block_mm", (0, -3.5), (body.clamp_block_mm, -3.5), (5, -6.5)),
        Dimension("tip_mm", (outer[3][1], -3.5), (length, -3.5), (length - 2, -6.5)),
        Dimension("chamber_length_mm", (inside[0][0], depth - 4), (inside[0][1], depth - 4),
                  (10, depth + 4)),
        Dimension("wall_mm", (outer[2][0], depth - 5), (inside[2][0], depth - 5),
                  (34, depth + 4)),
        Dimension("gap_mm", (outer[1][1], depth - 2), (outer[2][0], depth - 2), (28, depth + 7)),
        Dimension("roof_mm", (amid, roof), (amid, depth), (22, depth + 4)),
        Dimension("chamber_height_mm", (inside[3][0] + 3, floor), (inside[3][0] + 3, roof),
                  (46, depth + 7)),
        Dimension("tunnel_height_mm", (outer[1][1] + 1, floor), (outer[1][1] + 1, tunnel),
                  (28, -8.5)),
        Dimension("cover_mm", (length + 4, paper), (length + 4, floor), (length + 9, floor + 3)),
        Dimension("paper_mm", (length + 2.5, body.base_mm), (length + 2.5, paper),
                  (length + 9, floor - 0.5)),
        Dimension("base_mm", (length + 1, 0), (length + 1, body.base_mm), (length + 9, 0)),
    ])  # fmt: skip
    boxes(across, solid, 1, 0, amid)
    half, wide, narrow = body.width_mm / 2, body.chamber_width_mm / 2, body.tunnel_width_mm / 2
    extend(across, [((y, 0), (y, -9.5)) for y in (-half, half)])
    across.plot([-narrow, -narrow, narrow, narrow], [floor, tunnel, tunnel, floor], "--",
                color=theme.GREY, lw=0.6)  # fmt: skip
    draw(across, [
        Dimension("width_mm", (-half, -9), (half, -9)),
        Dimension("chamber_width_mm", (-wide, roof - 3), (wide, roof - 3), (0, depth + 4)),
        Dimension("tunnel_width_mm", (-narrow, floor + 1), (narrow, floor + 1), (0, -4.5)),
    ])  # fmt: skip
    save([along, across], "pneunet")


def round_bellows() -> None:
    """The two round bellows: section in the plane of symmetry, and across a convolution."""
    body = geometry({"finger.kind": "round_bellows", "round_bellows.convolutions": 3,
                     "round_bellows.tube_mm": 2.0, "solver.element": "P2"})  # fmt: skip
    assert isinstance(body, RoundBellows)
    solid = body.solid()
    assert isinstance(solid, CylinderSolid)
    length, depth, crown = body.length_mm, body.depth_mm, body.crown_radius_mm
    along, across = page([(f"{PLANE}; convolutions = 3", -14, length + 16, -12, depth + 10),
                          ("across a convolution", -crown - 6, crown + 6, -12, depth + 10)],
                         width_in=6.2)  # fmt: skip
    rectangles(along, solid.blocks, 2, 0, BODY)
    hollows = [part for cavity in solid.cavities for part in cavity]
    for parts, colour in ((solid.cylinders, BODY), (hollows, AIR)):
        for part in parts:
            (start, end), low = part.along_mm, part.axis_mm - part.radius_mm
            along.add_patch(
                Rectangle((start, low), end - start, 2 * part.radius_mm, fc=colour, ec="none")
            )
    first, second, third = body.crowns()
    top = depth - crown
    draw(along, [
        Dimension("block_mm", (0, -3), (body.block_mm, -3), (2.5, -6.5)),
        Dimension("pitch_mm", (first[0], -3), (second[0], -3), (12, -6.5)),
        Dimension("gap_mm", (second[1], crown - 8), (third[0], crown - 8), (25, -6.5)),
        Dimension("crown_radius_mm", (third[1] - 2, crown), (third[1] - 2, 0), (length + 9, 6)),
        Dimension("neck_radius_mm", (third[1] + 0.6, top),
                  (third[1] + 0.6, top + body.neck_radius_mm), (length + 9, top + 6)),
        Dimension("wall_mm", (second[0], top + 8), (second[0] + body.wall_mm, top + 8),
                  (13, depth + 6)),
        Dimension("apart_mm", (length - 2, crown * 2), (length - 2, top - crown),
                  (length + 9, depth / 2)),
        Dimension("tube_mm", (2.5, top - body.tube_mm / 2), (2.5, top + body.tube_mm / 2),
                  (-8, top + 7)),
    ])  # fmt: skip
    for axis, name in ((top, "cavity"), (crown, "cavity_2")):
        along.plot([-2, length + 2], [axis, axis], "-.", color=theme.GREY, lw=0.5)
        along.text(-3, axis, name, ha="right", va="center", fontsize=6.5, family="monospace")
    for axis in (crown, top):
        for radius, colour in ((crown, BODY), (crown - body.wall_mm, AIR)):
            across.add_patch(Circle((0, axis), radius, fc=colour, ec="none"))
    outline(across, solid.blocks[:1], 1, 0)
    draw(across, [Dimension("crown_radius_mm", (0, top), (crown, top), (0, top - 5))])
    save([along, across], "round_bellows")


if __name__ == "__main__":
    bellows()
    cast()
    pneunet()
    round_bellows()
