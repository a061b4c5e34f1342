"""The files of a finger's reduced model."""

from __future__ import annotations

from pathlib import Path

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.food import GraspedBody, grasped
from dolfingrip.experiments.rigs.gripper import stands_of
from dolfingrip.files import whole
from dolfingrip.meshes.gripper import Stand
from dolfingrip.robot import control, mjcf, urdf
from dolfingrip.robot.build import Built


def room(config: Config) -> tuple[GraspedBody, list[Stand]]:
    """Place a gripper's fingers around the food.

    Args:
        config: with the gripper's pose and the food.

    Returns:
        The food, and the places of the fingers.

    Raises:
        ConfigError: one line, where they have no room.
    """
    body = grasped(config.food)
    return body, stands_of(config, body)


def write(
    built: Built, config: Config, placed: tuple[GraspedBody, list[Stand]] | None, out: Path
) -> list[Path]:
    """Write robot.json, MuJoCo's models of finger, gripper and scene, and finger.urdf.

    Args:
        built: reduced model and skin.
        config: with the friction of the food.
        placed: what :func:`room` gave; None: no gripper and no scene are written.
        out: folder.

    Returns:
        The files.

    Raises:
        WriteError: one line.
    """
    file, skin, friction = built.robot.file, built.skin, config.food.friction
    texts = {
        "finger.xml": mjcf.finger(file, skin, friction),
        "finger.urdf": urdf.finger(file),
        "control.py": Path(control.__file__).read_text(encoding="utf-8"),
    }
    if placed is not None:
        body, stands = placed
        speed = config.gripper.lift_mm_per_s
        texts["gripper.xml"] = mjcf.gripper(file, skin, stands, friction, speed)
        texts["scene.xml"] = mjcf.scene(config.food, body, "gripper.xml")
    found = [file.write(out)]
    for name, text in texts.items():
        whole.write(out / name, text)
        found.append(out / name)
    return found
