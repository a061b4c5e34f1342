"""The scene of a run: a finger or coupon with its plate, or a gripper with food and table."""

from __future__ import annotations

import numpy as np

from dolfingrip.report.beside import Beside
from dolfingrip.report.page import finger, gripper
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.runs import Run
from dolfingrip.report.page.scene import FINGER_VIEW, GRIPPER_VIEW, UPRIGHT, Load, Scene, towards
from dolfingrip.report.scene import slab


def scene_of(run: Run, fields: finger.Fields | None = None) -> Scene:
    """The scene of a run.

    Args:
        run: with fields.
        fields: of a run that is no grasp; None: they are read.

    Raises:
        ValueError: one line, if its files are missing or hold something else.
    """
    if run.experiment.pictures == "gripper":
        return _grasp(run)
    return _finger(run, finger.read(run.fields, len(run.result)) if fields is None else fields)


def _finger(run: Run, fields: finger.Fields) -> Scene:
    clamped = "finger" in run.experiment.parts
    name = "finger" if clamped else "coupon"
    parts = finger.parts(fields, name, clamped=clamped)
    others = Beside.of_run(run.result.config, run.result.plate)
    if others.plate is not None:
        rest = fields.mesh.points
        sizes, axes, centre = slab(rest.min(axis=0), rest.max(axis=0), others.plate)
        sensor = finger.block("force sensor", -sizes, sizes * [0, 1, 1], axes, centre)
        parts.append(sensor)
    if clamped and others.food is not None:
        parts.append(gripper.food_part(others.food, others.food.points[None] * UPRIGHT))
    load = _load(run, fields.rows)
    alt = f"{run.title}: the deformed {name} in 3D, {said(load.values[-1], load.unit)} at the end"
    return Scene(run.title, alt, run.experiment.name, parts, load, towards(FINGER_VIEW))


def _grasp(run: Run) -> Scene:
    parts, rows = gripper.parts(run.folder, run.result.config, run.result)
    outcome = "" if run.result.outcome is None else run.result.outcome.kind
    alt = f"{run.title}: three fingers, food and table in 3D; {outcome}"
    return Scene(
        run.title, alt, run.experiment.name, parts, _load(run, rows), towards(GRIPPER_VIEW),
        axes=np.ones(3),
    )  # fmt: skip


def _load(run: Run, rows: np.ndarray) -> Load:
    over = run.experiment.plot.over
    values = run.column(over.name)
    if values is None:
        values = np.arange(len(run.result), dtype=float)
    branch = run.branch
    several = len(set(branch)) > 1
    names = [branch[row] if several else "" for row in rows]
    return Load(over.label, over.symbol, values[rows], names, rows)
