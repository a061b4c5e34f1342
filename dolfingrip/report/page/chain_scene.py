"""A chain of links beside the finite elements it was fitted to, in 3D."""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.files.robot import RobotFile
from dolfingrip.report.page.scene import FINGER_VIEW, UPRIGHT, Load, Scene, ScenePart, towards
from dolfingrip.report.skin import Floats, Ints, Skin

RINGS: Final = 12
"""Outlines of the bent finger along each link."""

APART: Final = 1.1
"""Distance of the two in the plane of bending, by the way that both take there."""


def scene_of(robot: RobotFile) -> Scene:
    """Return both at the pressures of the free finger.

    Args:
        robot: with shapes.
    """
    levels = np.array(robot.levels_mm)
    sections = np.array([shape.finite_elements for shape in robot.shapes])
    rigid = np.array([shape.chain for shape in robot.shapes])
    bent: list[_Body] = []
    chained: list[_Body] = []
    for number, link in enumerate(robot.links):
        outline = np.array(link.section_mm)
        along = np.linspace(link.from_mm, link.to_mm, RINGS)
        moved = np.array(
            [[np.interp(along, levels, column) for column in step.T] for step in sections]
        )
        bent.append(_body(outline, moved.swapaxes(1, 2)))
        x, z, turn = np.moveaxis(rigid[:, number, :, None], 1, 0)
        up = np.array([0.0, link.to_mm - link.from_mm])
        ends = (x - up * np.sin(turn), z + up * np.cos(turn), turn + 0 * up)
        chained.append(_body(outline, np.stack(ends, axis=-1)))
    pressures = np.array([shape.pressure_kPa for shape in robot.shapes])
    unloaded = int(np.abs(pressures).argmin())
    apart_mm = APART * float(np.ptp(np.concatenate([body[0][..., 0] for body in bent], axis=1)))
    parts = [
        _part("finite elements", bent, 0.0, unloaded),
        _part("chain of links", chained, apart_mm, unloaded),
    ]
    steps = np.arange(len(pressures))
    load = Load("Pressure (kPa)", "kPa", pressures, [""] * len(steps), steps)
    alt = (
        "the free finger in 3D: its sections as finite elements move them, and beside it the links "
        f"of the chain; {pressures[-1]:g} kPa at the end"
    )
    return Scene("Reduced model", alt, "robot", parts, load, towards(FINGER_VIEW))


_Body = tuple[Floats, Ints, Ints]
"""Places (steps, points, 3), triangles and creases."""


def _body(outline: Floats, motions: Floats) -> _Body:
    """The surface through a convex outline (corners, 2) of x, y at rings that move.

    Motions (steps, rings, 3) are x and z of what lies at x = 0 at rest, and the turn.
    """
    x, z, turn = (motions[..., i, None] for i in range(3))
    across = outline[:, 0]
    y = np.broadcast_to(outline[:, 1], (*turn.shape[:-1], len(outline)))
    places = np.stack([x + across * np.cos(turn), y, z + across * np.sin(turn)], axis=-1)
    rings, count = places.shape[1:3]
    corner = np.arange(count)
    following = np.roll(corner, -1)
    first = np.array([[ring * count] for ring in range(rings - 1)])
    a, b = (first + corner).ravel(), (first + following).ravel()
    caps = np.stack([0 * corner[2:], corner[1:-1], corner[2:]], axis=1)
    triangles = np.concatenate(
        [np.stack([a, b, b + count], 1), np.stack([a, b + count, a + count], 1),
         caps[:, ::-1], caps + (rings - 1) * count]
    )  # fmt: skip
    ring = np.stack([corner, following], axis=1)
    creases = np.concatenate([ring, ring + (rings - 1) * count])
    return places.reshape(len(places), -1, 3), triangles, creases


def _part(name: str, bodies: list[_Body], x_mm: float, unloaded: int) -> ScenePart:
    starts = np.cumsum([0, *(places.shape[1] for places, _, _ in bodies[:-1])])
    places = np.concatenate([body[0] for body in bodies], axis=1) + np.array([x_mm, 0.0, 0.0])
    triangles, creases = (
        np.concatenate([body[of] + start for body, start in zip(bodies, starts, strict=True)])
        for of in (1, 2)
    )
    frames = places * UPRIGHT
    at_rest = frames[[unloaded]]
    skin = Skin.plain(frames[unloaded], triangles, creases)
    return ScenePart(name, skin, np.concatenate([at_rest, frames]))
