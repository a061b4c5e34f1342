"""The files of a finger's reduced model."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Final

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.food import GraspedBody, grasped
from dolfingrip.experiments.rigs.gripper import stands_of
from dolfingrip.files import whole
from dolfingrip.files.robot import Speed
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


SPEED_S: Final = 2.0
"""Simulated time over which the speed is measured."""


def measured_speed(model_text: str) -> Speed | None:
    """Measure how fast MuJoCo steps a model at the highest pressure.

    Args:
        model_text: of finger.xml.

    Returns:
        Its speed; None where there is no MuJoCo.
    """
    try:
        import mujoco
    except ImportError:
        return None
    model = mujoco.MjModel.from_xml_string(model_text)
    data, step_s = mujoco.MjData(model), float(model.opt.timestep)
    data.ctrl[0] = model.actuator_ctrlrange[0, 1]
    begun = time.process_time()
    mujoco.mj_step(model, data, nstep=round(SPEED_S / step_s))
    factor = SPEED_S / (time.process_time() - begun)
    return Speed(times_real_time=factor, step_s=step_s, mujoco=mujoco.__version__)


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
    files = [file.model_copy(update={"speed": measured_speed(texts["finger.xml"])}).write(out)]
    for name, text in texts.items():
        whole.write(out / name, text)
        files.append(out / name)
    return files
