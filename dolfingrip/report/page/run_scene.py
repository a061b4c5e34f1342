"""The scene of a run: a finger or coupon with its plate, or a gripper with food and table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.channels import MOVED
from dolfingrip.charts.theme import PALE
from dolfingrip.config import Config
from dolfingrip.experiments.rigs.food import grasped
from dolfingrip.files.table import Columns
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.report.beside import Beside
from dolfingrip.report.gripper import moments_of
from dolfingrip.report.page import finger
from dolfingrip.report.page.finger import box_skin, shown_rows
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.runs import Run, over
from dolfingrip.report.page.scene import (
    FINGER_VIEW,
    GRIPPER_VIEW,
    UPRIGHT,
    Floats,
    Load,
    Scene,
    ScenePart,
    towards,
)
from dolfingrip.report.scene import slab
from dolfingrip.report.skin import Ints, Skin

NAMES: Final = ("thumb A", "finger B", "finger C")

TABLE_MM: Final = 4.0
"""Thickness of the table as drawn."""

AROUND_MM: Final = 8.0
"""How far the table stands out beyond the fingers."""


def gripper_parts(folder: Path, config: Config, result: Columns) -> tuple[list[ScenePart], Ints]:
    """Return fingers, food and table at the steps that are shown, and the row of each step.

    Args:
        folder: of the grasp's result.
        config: of the grasp.
        result: its columns.

    Raises:
        ValueError: one line, if the fields are missing or hold something else.
    """
    body = grasped(config.food)
    skin, moments = moments_of(folder / "fields.pvd", config, result, body)
    rows = shown_rows(len(moments))
    displacements = [np.linalg.norm(moments[row].displacement, axis=1) for row in rows]
    fields = {
        name: np.array([moments[row].fields[name] for row in rows]) for name in moments[0].fields
    }
    fields[MOVED.name] = np.array(displacements)
    up = np.array([0.0, 0.0, 1.0])
    places = np.array([moments[row].skin - up * moments[row].table_mm for row in rows])
    frames = np.concatenate([places[:1], places])
    parts = [_finger(skin, number, name, frames, fields) for number, name in enumerate(NAMES)]
    food = np.array([moments[row].food - up * moments[row].table_mm for row in rows])
    colour = config.food.shape.colour
    parts.append(food_part(body.surface, np.concatenate([food[:1], food]), colour))
    parts.append(table_part(np.concatenate([frames[0], food[0]])))
    return [part for part in parts if len(part.skin.triangles)], rows


def _finger(
    skin: Skin, number: int, name: str, frames: Floats, fields: Mapping[str, Floats]
) -> ScenePart:
    """One finger of the skin."""
    mine = skin.side == number
    return ScenePart(
        name, replace(skin, points=frames[0]).part(mine), frames[:, mine],
        fields={field: values[:, mine] for field, values in fields.items()}, cut=True,
    )  # fmt: skip


def food_part(food: ClosedSurface, places: Floats, colour: str) -> ScenePart:
    """Return the food as a part of a scene.

    Args:
        food: its surface, whose triangles are taken.
        places: of its surface's points (mm), shape (frames, points, 3).
        colour: of the food.
    """
    return ScenePart("food", Skin.plain(places[0], food.triangles), places, colour=colour)


def table_part(around: Floats) -> ScenePart:
    """Return a table as a part of a scene.

    Args:
        around: points (mm) above it, shape (points, 3).
    """
    low, high = around.min(axis=0) - AROUND_MM, around.max(axis=0) + AROUND_MM
    low[2], high[2] = -TABLE_MM, 0.0
    skin = box_skin(low, high)
    return replace(ScenePart("table", skin, skin.points[None]), colour=PALE)


def scene_of(run: Run, fields: finger.Fields | None = None) -> Scene:
    """The scene of a run.

    Args:
        run: with fields.
        fields: of a run that is no grasp; None: they are read.

    Raises:
        ValueError: one line, if its files are missing or hold something else.
    """
    if run.experiment.pictures == "gripper":
        return _gripper(run)
    return _single(run, finger.read(run.fields, len(run.result)) if fields is None else fields)


def _single(run: Run, fields: finger.Fields) -> Scene:
    clamped = "finger" in run.experiment.parts
    name = "finger" if clamped else "coupon"
    parts = finger.parts(fields, name, clamped=clamped)
    others = Beside.of_run(run.result.config, run.result.plate)
    if others.plate is not None:
        at_rest = fields.mesh.points
        sizes, axes, centre = slab(at_rest.min(axis=0), at_rest.max(axis=0), others.plate)
        sensor = finger.block("force sensor", -sizes, sizes * [0, 1, 1], axes, centre)
        parts.append(sensor)
    if clamped and others.food is not None:
        parts.append(food_part(others.food, others.food.points[None] * UPRIGHT, others.food_colour))
    load = _load(run, fields.rows)
    alt = f"{run.title}: the deformed {name} in 3D, {said(load.values[-1], load.unit)} at the end"
    return Scene(run.title, alt, run.experiment.name, parts, load, towards(FINGER_VIEW))


def _gripper(run: Run) -> Scene:
    parts, rows = gripper_parts(run.folder, run.result.config, run.result)
    outcome = "" if run.result.outcome is None else run.result.outcome.kind
    alt = f"{run.title}: three fingers, food and table in 3D; {outcome}"
    return Scene(
        run.title, alt, run.experiment.name, parts, _load(run, rows), towards(GRIPPER_VIEW),
        axes=np.ones(3),
    )  # fmt: skip


def _load(run: Run, rows: np.ndarray) -> Load:
    along = over(run)
    values = run.column(along.name)
    if values is None:
        values = np.arange(len(run.result), dtype=float)
    branch = run.branch
    several = len(set(branch)) > 1
    names = [branch[row] if several else "" for row in rows]
    return Load(along.label, along.symbol, values[rows], names, rows)
