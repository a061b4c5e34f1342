"""A reduced model beside finite elements, its speed, and how MuJoCo loads it, on a page."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from dolfingrip.charts.chart import Axis, Chart, Mark, Series
from dolfingrip.files.robot import QuantityError, RobotFile
from dolfingrip.report.page import chain_scene
from dolfingrip.report.page.content import Contribution, FoundResult, KeyNumber, Page, Source
from dolfingrip.report.page.numbers import said

LINES: Final = """\
import sys

import mujoco

sys.path.append({folder!r})
from control import JointLaws

model = mujoco.MjModel.from_xml_path({model!r})
data = mujoco.MjData(model)
data.actuator("pressure_kPa").ctrl = {highest:g}
while data.time < 1:
    mujoco.mj_step(model, data)
finger = JointLaws({file!r})
model.skin_rgba[:, :3] = finger.colour(data.sensor("pressure_kPa").data[0])
print("tip from the clamp (m):", data.sensor("tip_m").data)

# in a window: python -m mujoco.viewer --mjcf={shown}
"""
"""Loads a finger in MuJoCo, lets it come to rest under pressure, and colours it by that."""


class ReducedModel(Contribution):
    """Each quantity by finite elements and by the chain, at states that were not fitted."""

    marks: ClassVar = {"robot": RobotFile.FILE}
    titles: ClassVar = {"robot": "reduced model"}
    place = 70

    def show(self, page: Page, result: FoundResult) -> None:
        robot = RobotFile.read(result.folder)
        page.numbers.append(_speed(robot))
        if robot.shapes:
            page.scenes.append(chain_scene.scene_of(robot).packed())
        for error in robot.comparisons:
            page.charts.append(_chart(error))
            unit = _symbol(error)
            page.numbers.append(
                KeyNumber(
                    f"Error: {error.title}", f"{said(error.rms, unit)} rms", "",
                    f"{said(error.largest, unit)} at most, at states that were not fitted",
                )
            )  # fmt: skip
        (low, high), gaps = robot.valid.pressure_kPa, robot.valid.gaps_mm
        page.code.append(("In MuJoCo", _lines(result.folder, high)))
        facts = [
            ("joints", f"{len(robot.joints)}"),
            ("valid", f"{low:g} to {high:g} kPa, up to {robot.valid.force_N:.3g} N"),
            ("valid for plates", f"at {min(gaps):.3g} to {max(gaps):.3g} mm"),
            *robot.versions.items(),
        ]
        again = f"{RobotFile.MADE_BY} {shlex.quote(str(result.folder / RobotFile.FILE))}"
        page.sources.append(Source("Reduced model", str(result.folder), again, facts))


def _lines(folder: Path, highest_kPa: float) -> str:
    model, file = str(folder / "finger.xml"), str(folder / RobotFile.FILE)
    return LINES.format(
        folder=str(folder), model=model, file=file, highest=highest_kPa, shown=shlex.quote(model)
    )


def _speed(robot: RobotFile) -> KeyNumber:
    if robot.speed is None:
        return KeyNumber("Speed in MuJoCo", "–", "open", "not measured: MuJoCo was not installed")
    words = f"one finger, steps of {1e3 * robot.speed.step_s:g} ms, one core"
    return KeyNumber("Speed in MuJoCo", f"{robot.speed.times_real_time:.0f} × real time", "", words)


def _symbol(error: QuantityError) -> str:
    return {"deg": "°"}.get(error.unit, error.unit)


def _chart(error: QuantityError) -> Chart:
    p, unit, across = error.pressure_kPa, _symbol(error), Axis("Pressure (kPa)", "kPa")
    theirs, ours = np.array(error.finite_elements), np.array(error.chain)
    series = (
        Series("finite elements", p, theirs, "points", colour="ink"),
        Series("reduced model", p, ours, colour="orange"),
    )
    off = Series("reduced model", p, ours - theirs, "points", colour="orange")
    below = Chart("", across, Axis(f"Difference ({unit})", unit, "difference"), [off], [Mark(0.0)])
    kind = "Error of the place" if error.unit == "mm" else "Error"  # sideways, too
    note = f"None of these states was fitted. {kind}: {said(error.rms, unit)} rms, "
    note += f"{said(error.largest, unit)} at most."
    title = f"Reduced model: {error.title}"
    up = Axis(f"{error.quantity.capitalize()} ({unit})", unit)
    return Chart(title, across, up, series, note=note, below=below)
