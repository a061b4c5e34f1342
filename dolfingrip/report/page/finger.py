"""The scene of one finger, or of a coupon, from the fields of a run; and of a design at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from dolfingrip.charts.theme import PALE
from dolfingrip.config import Config
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.report.fields import FieldMesh, list_steps, read_steps
from dolfingrip.report.page.scene import (
    FINGER_VIEW,
    UPRIGHT,
    Floats,
    Load,
    Scene,
    ScenePart,
    towards,
)
from dolfingrip.report.scene import clamp
from dolfingrip.report.skin import Skin, extract_skin

CELL_CORNERS: Final = {4: 4, 10: 4, 8: 8, 20: 8, 27: 8}
"""Corners of an element, by its nodes."""


MOST_STEPS: Final = 41
"""Steps of a run that a page shows; others are left out evenly, and the page says so."""

MOST_PLACES: Final = 700_000
"""Points times frames; a finer mesh is drawn by the corners of its elements."""


@dataclass(frozen=True, slots=True)
class Fields:
    """The fields of a run at the steps that are shown.

    Attributes:
        mesh: at rest.
        displacements: shape (nodes, 3) in mm, for each step.
        further: by the name of each further field, shape (nodes,), for each step.
        rows: row of the result of each step.
    """

    mesh: FieldMesh
    displacements: Sequence[Floats]
    further: Mapping[str, Sequence[Floats]]
    rows: npt.NDArray[np.int64]


def shown_rows(count: int) -> npt.NDArray[np.int64]:
    """Return the rows of so many that a page shows.

    Args:
        count: of a result with fields.
    """
    rows = np.linspace(0, count - 1, min(count, MOST_STEPS))
    return np.unique(np.round(rows).astype(np.int64))


def read(collection: Path, readings: int) -> Fields:
    """Read the fields of a run.

    Args:
        collection: ``fields.pvd``.
        readings: number of rows of the result; a run that was killed may have a step more.

    Raises:
        ValueError: one line, if files are missing or hold something else.
    """
    files = list_steps(collection)[:readings]
    rows = shown_rows(len(files))
    return Fields(*read_steps([files[row] for row in rows]), rows)


def shown_mesh(fields: Fields) -> FieldMesh:
    """The mesh whose skin is drawn: that of the corners alone if the whole one is too fine."""
    mesh = fields.mesh
    places = len(extract_skin(mesh, mirror=False).points) * (1 + len(fields.rows))
    if places <= MOST_PLACES:
        return mesh
    corners = CELL_CORNERS[mesh.cells.shape[1]]
    return replace(mesh, cells=mesh.cells[:, :corners])


def parts(fields: Fields, name: str, *, clamped: bool) -> list[ScenePart]:
    """The specimen's skin, its section if it is half of one, and its clamp.

    Args:
        fields: of the run.
        name: of the specimen.
        clamped: whether a block is drawn where it is held.
    """
    mesh = shown_mesh(fields)
    skin = extract_skin(mesh, mirror=True)
    pieces = []
    if (skin.side < 0).any():
        half = skin.part(skin.side > 0)
        pieces.append(_part(fields, half, name, mirrored=True))
        pieces.append(_part(fields, extract_skin(mesh, cut=True), name, section=True))
    else:
        pieces.append(_part(fields, skin, name, cut=True))
    if clamped:
        pieces.append(block("clamp", *clamp(skin), np.eye(3), np.zeros(3)))
    return pieces


def unloaded_shape(config: Config) -> Scene:
    """Return the scene of a design without load, meshed from its configuration.

    Args:
        config: of the design.

    Raises:
        ConfigError: one line, if it cannot be meshed.
    """
    mesh = solid(config.changed(mesh={"order": 1}))
    corners = mesh.cells[:, : mesh.shape.corners]
    shape = FieldMesh(mesh.points, corners, np.arange(len(mesh.points)))
    still = Fields(shape, [np.zeros_like(shape.points)], {}, np.zeros(1, dtype=np.int64))
    pieces = parts(still, "design", clamped=False)
    load = Load("", "", np.zeros(1), [""], still.rows)
    return Scene("design", "Shape of the design", "design", pieces, load, towards(FINGER_VIEW))


def _part(fields: Fields, skin: Skin, name: str, **kind: Any) -> ScenePart:
    frames = [skin.points, *(skin.move(displacement) for displacement in fields.displacements)]
    further = {k: np.array([step[skin.node] for step in v]) for k, v in fields.further.items()}
    return ScenePart(name, skin, np.array(frames) * UPRIGHT, fields=further, **kind)


def block(name: str, low: Floats, high: Floats, axes: Floats, centre: Floats) -> ScenePart:
    """A box that never moves, between corners in axes of its own.

    Args:
        name: of the part.
        low, high: corners, shape (3,), mm.
        axes: unit vectors, shape (3, 3), a row for each axis.
        centre: origin of the axes.
    """
    skin = box_skin(low, high)
    places = (centre + skin.points @ axes) * UPRIGHT
    return ScenePart(name, replace(skin, points=places), places[None], colour=PALE)


def box_skin(low: Floats, high: Floats) -> Skin:
    """The skin of a box, its edges as creases."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    points = np.where(corners == 1, high, low).astype(float)
    quads = np.array(
        [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    )
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    ends = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b).bit_count() == 1]
    return Skin.plain(points, triangles.astype(np.int64), np.array(ends, dtype=np.int64))
