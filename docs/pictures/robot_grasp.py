"""A grasp in MuJoCo, as a strip of pictures and as a film.

    scripts/run dolfingrip robot -o out/robot -s experiment.max_pressure_kPa=250
    MUJOCO_GL=egl scripts/run python docs/pictures/robot_grasp.py out/robot

draws ``docs/robot_grasp.png`` and ``docs/robot_grasp.gif``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import mujoco
import numpy as np
from PIL import Image

from dolfingrip.robot.control import JointLaws

DOCS = Path(__file__).resolve().parent.parent
PRESSURE_KPA, LIFT_M, EVERY = 150.0, 0.03, 80
TIMES_S, KPA, LIFTS_M = (0.0, 2.0, 2.5, 3.5, 4.0), (0, 1, 1, 1, 1), (0, 0, 0, 1, 1)
SHOWN_S = (0.0, 1.2, 2.4, 3.9)


def frames(folder: Path) -> dict[float, Image.Image]:
    """Pictures of the scene by their time."""
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    data, found, laws = mujoco.MjData(model), {}, JointLaws(folder / "robot.json")
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, 300, 360) as renderer:
        while data.time < TIMES_S[-1]:
            if round(data.time / model.opt.timestep) % EVERY == 0:
                model.skin_rgba[:, :3] = laws.colour(data.sensor("pressure_kPa").data[0])
                renderer.update_scene(data, camera="front")
                found[data.time] = Image.fromarray(renderer.render())
            data.actuator("pressure_kPa").ctrl = PRESSURE_KPA * np.interp(data.time, TIMES_S, KPA)
            data.actuator("lift_m").ctrl = LIFT_M * np.interp(data.time, TIMES_S, LIFTS_M)
            mujoco.mj_step(model, data)
    return found


if __name__ == "__main__":
    made = frames(Path(sys.argv[1]))
    first, *others = [each.quantize(64) for each in made.values()]
    first.save(
        DOCS / "robot_grasp.gif", save_all=True, append_images=others, duration=EVERY, loop=0
    )
    times = np.array(list(made))
    chosen = [made[times[np.abs(times - shown).argmin()]] for shown in SHOWN_S]
    Image.fromarray(np.hstack([np.asarray(each) for each in chosen])).save(DOCS / "robot_grasp.png")
