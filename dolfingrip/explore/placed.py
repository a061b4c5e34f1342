"""A gripper before it is solved: fingers in their places, food and table, in the table's frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.grasped import grasped
from dolfingrip.experiments.rigs.gripper import stands_of
from dolfingrip.meshes.gripper import Stand
from dolfingrip.report.page import gripper
from dolfingrip.report.page.scene import GRIPPER_VIEW, UPRIGHT, Floats, Part, Scene, towards


def placed(config: Config, finger: Scene) -> Scene:
    """Three fingers around their food; they move as the one finger does, which feels no food.

    Args:
        config: with gripper and food.
        finger: scene of one finger, unloaded or in free bending.

    Raises:
        ConfigError: one line, if there is no room for the fingers.
    """
    body = grasped(config.food)
    parts: list[Part] = []
    for stand, name in zip(stands_of(config, body), gripper.NAMES, strict=True):
        for part in finger.parts:
            if part.name != "clamp" and not part.section:
                parts += _copies(part, stand, name)
    food = body.surface.points + np.array(body.body.centre_mm)
    around = np.concatenate([food, *(part.frames[0] for part in parts)])
    parts += [gripper.food_part(body, food[None]), gripper.table_part(around)]
    alt = "Three fingers around the food on its table, before the grasp is solved"
    return replace(
        finger, title="Gripper", alt=alt, kind="grasp", parts=parts,
        towards=towards(GRIPPER_VIEW), solved=False,
    )  # fmt: skip


def _copies(part: Part, stand: Stand, name: str) -> list[Part]:
    """A part of the finger where the finger stands, with its mirror image as a part of its own."""
    found = []
    for side in (1.0, -1.0) if part.mirrored else (1.0,):
        frames = part.frames * UPRIGHT * np.array([1.0, side, 1.0])
        frames = frames @ stand.rotation.T + stand.origin_mm
        skin = part.skin
        if side < 0:
            skin = replace(skin, triangles=skin.triangles[:, ::-1])
        skin = replace(skin, points=frames[0])
        displacement: Floats = np.linalg.norm(part.frames[1:] - part.frames[0], axis=2)
        found.append(
            replace(
                part, name=name, skin=skin, frames=frames, displacement=displacement,
                mirrored=False, cut=False,
            )
        )  # fmt: skip
    return found
