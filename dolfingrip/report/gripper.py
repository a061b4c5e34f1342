"""Pictures, an animation and fields of a gripper with its food, in the laboratory's frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import pyvista as pv
from matplotlib.colors import ListedColormap
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from dolfingrip.channels import FIELDS, INSIDE, MOVED, PRESSURE, TIME, Colour
from dolfingrip.charts.theme import BLUE, GREEN, INK, PALE, colour_map
from dolfingrip.config import Config
from dolfingrip.experiments.results.fields import COLLECTION
from dolfingrip.experiments.rigs.food import MIRROR, GraspedBody, grasped, halved
from dolfingrip.experiments.rigs.gripper import placed, stands_of
from dolfingrip.files import whole
from dolfingrip.files.table import Columns
from dolfingrip.mechanics.model.placement import to_world
from dolfingrip.report import video
from dolfingrip.report.drawers import WantedPictures
from dolfingrip.report.fields import list_steps, read_steps
from dolfingrip.report.opened import sawn
from dolfingrip.report.render import Pictures, colour_range
from dolfingrip.report.scene import (
    Image,
    PaintedSkin,
    View,
    aim,
    framing,
    segments_of,
    shot,
    stage,
    surface_of,
)
from dolfingrip.report.skin import Floats, Ints, Skin, extract_skin, mid_plane

COLOURS = (GREEN, BLUE, BLUE)
"""Colours of thumb A, finger B and finger C."""


HEIGHT_PX: Final = 880
"""Height of the pictures."""

VIEW: Final = View(azimuth_deg=35.0, elevation_deg=14.0, up=1.0)
"""From where a gripper is seen."""

FILM_S: Final = (3.0, 10.0)
"""Shortest and longest film; between them it runs at the grasp's own speed."""

AROUND_MM: Final = 25.0
"""How far the table stands out beyond the food."""

SHADE: Final = "#BDBDB7"
"""Colour of shadows on the table; it is opaque, as those of several bodies lie in one another."""

MARGIN: Final = 1.04
"""Width and height of the picture, by those of what it shows."""

IN_PLANE_MM: Final = 1e-6
"""Distance from the plane of symmetry within which a node lies in it."""


@dataclass(frozen=True)
class GraspFrame:
    """One row of a result.

    Attributes:
        skin: (n, 3) positions of the fingers' skin, seen from the gripper.
        food: (m, 3) positions of the food's surface, seen from the gripper.
        table_mm: height of the table, seen from the gripper.
        displacement: (n, 3) displacements (mm) of the skin, in the laboratory's directions.
        fields: (n,) values of the skin by the names of further fields.
        time_s: time of the row.
        label: time, pressure and stage in words.
    """

    skin: Floats
    food: Floats
    table_mm: float
    displacement: Floats
    fields: Mapping[str, Floats]
    time_s: float
    label: str


def draw(out: Path, config: Config, result: Columns, look: WantedPictures) -> list[Path]:
    """Write ``grasp.png`` with the stages side by side, and the film ``grasp.gif`` and ``.mp4``.

    ``grasp.pvd`` has the fingers where they stand, the food and the table, for ParaView. Without
    PyAV there is no ``.mp4``, and a warning says so.

    Args:
        out: folder of a run, with its ``fields.pvd``.
        config: configuration of the run.
        result: columns of the run's result.
        look: colours, cut and film; fingers are coloured by their stretch where none is asked for.

    Returns:
        The pictures and films.

    Raises:
        ValueError: one line, if the fields lack the one of the colours.
    """
    body, colour_by = grasped(config.food), look.colour_by or "stretch"
    skin, moments = moments_of(out / "fields.pvd", config, result, body)
    write_scene(out / "grasp.pvd", skin, body, moments)
    if look.cut:
        skin, moments = moments_of(out / "fields.pvd", config, result, body, VIEW)
    shown = [moments[i] for i in stages(list(result["branch"]))]
    files = [_pictures(skin, body, shown, config, colour_by).save_strip(out / "grasp.png")]
    if look.video:
        film = filmed(moments, result, look.seconds, [colour_by])
        turning = _pictures(skin, body, film, config, colour_by, look.turn_deg)
        files += turning.save_video(out / "grasp")
    return files


def filmed(
    moments: Sequence[GraspFrame],
    result: Columns,
    seconds: float | None = None,
    fields: Sequence[str] = (),
) -> list[GraspFrame]:
    """Find what a film shows: the bodies at every picture, between the rows of a result.

    Args:
        moments: of all rows, at times that do not fall.
        result: columns of the result.
        seconds: length of the film; None: it is as long as the grasp, within :data:`FILM_S`.
        fields: names of the fields that are shown; others are left out.

    Returns:
        A moment for each picture.
    """
    every_s = np.array([moment.time_s for moment in moments])
    rows = np.flatnonzero(np.diff(every_s, prepend=-1.0) > 0)
    time_s = every_s[rows]
    if len(rows) < 2:
        return list(moments)
    lasts_s = seconds or float(np.clip(np.ptp(time_s), *FILM_S))
    at = np.linspace(time_s[0], time_s[-1], video.POLICY.frames(lasts_s) + 1)

    def between(values: Sequence[Any]) -> Floats:
        kept = np.array([values[row] for row in rows], dtype=float)
        return np.asarray(PchipInterpolator(time_s, kept)(at))

    skin, food = between([m.skin for m in moments]), between([m.food for m in moments])
    stored = moments[0].fields
    shown = {key: between([m.fields[key] for m in moments]) for key in fields if key in stored}
    tables, pressures = between([m.table_mm for m in moments]), between(result[PRESSURE.name])
    towards = rows[np.searchsorted(time_s, at - 1e-9).clip(max=len(rows) - 1)]
    return [
        GraspFrame(
            skin[i], food[i], float(tables[i]), skin[i] - skin[0],
            {name: values[i] for name, values in shown.items()}, float(now),
            label(float(now), round(float(pressures[i])), str(result["branch"][row])),
        )
        for i, (now, row) in enumerate(zip(at, towards, strict=True))
    ]  # fmt: skip


def label(time_s: float, pressure_kPa: float, branch: str) -> str:
    """Say time, pressure and stage of a grasp in words.

    Args:
        time_s: of the row.
        pressure_kPa: of the row.
        branch: of the row, such as ``loading``, ``hold`` or ``lift``.
    """
    stage = {
        "loading": "opening" if pressure_kPa < 0 else "pressurising",
        "unloading": "closing",
        "hold": "holding",
        "lift": "lifting",
        "approach": "approaching",
    }.get(branch, branch)
    if not time_s:
        stage = "at rest"
    return f"{time_s:z.2f} s, {pressure_kPa:z.4g} kPa, {stage}"


def write_scene(file: Path, skin: Skin, body: GraspedBody, moments: Sequence[GraspFrame]) -> None:
    """Write fingers, food and table at each moment as one ParaView collection.

    The table stands still at z = 0. The fingers have their displacement and all
    further fields; ``finger`` is 0 for the thumb, 1 and 2 for the fingers.

    Args:
        file: the collection; its parts stand in a folder of its stem beside it.
        skin: the fingers' skin.
        body: the food.
        moments: rows of the result.
    """
    folder = file.with_name(f"{file.stem}_fields")
    table, entries = _table(moments), []
    _write_vtp(table, folder / "table.vtp")
    food: Any = body.surface.polydata()
    for i, moment in enumerate(moments):
        up = np.array([0.0, 0.0, -moment.table_mm])
        points = (moment.skin + up).astype(np.float32)
        fingers = surface_of(points, skin.triangles)
        fingers["displacement_mm"] = moment.displacement.astype(np.float32)
        for name, values in moment.fields.items():
            fingers[FIELDS[name].array] = values.astype(np.float32)
        fingers["finger"] = skin.side.astype(np.int8)
        _write_vtp(fingers, folder / f"fingers{i:04d}.vtp")
        food.points = moment.food + up
        _write_vtp(food, folder / f"food{i:04d}.vtp")
        parts = (f"fingers{i:04d}.vtp", f"food{i:04d}.vtp", "table.vtp")
        entries += [
            f'    <DataSet timestep="{moment.time_s:.10g}" part="{part}" '
            f'file="{folder.name}/{name}" />'
            for part, name in enumerate(parts)
        ]
    whole.write(file, COLLECTION.format("\n".join(entries)))


def _write_vtp(surface: Any, file: Path) -> None:
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(surface)
    writer.SetDataModeToBinary()
    writer.WriteToOutputStringOn()
    writer.Write()
    whole.write(file, writer.GetOutputString())


def strip(out: Path, config: Config, result: Columns) -> Image:
    """The stages of a grasp side by side."""
    body = grasped(config.food)
    skin, moments = moments_of(out / "fields.pvd", config, result, body)
    shown = [moments[i] for i in stages(list(result["branch"]))]
    return np.concatenate(_pictures(skin, body, shown, config, "none").images, axis=1)


def stages(branches: Sequence[str]) -> list[int]:
    """Rows that show a grasp: the start, half-way or opened, the fingers closed, and the end."""
    last = {branch: row for row, branch in enumerate(branches)}
    closed = last.get("loading", 0)
    return list(dict.fromkeys([0, last.get("approach", closed // 2), closed, len(branches) - 1]))


def moments_of(
    fields: Path, config: Config, result: Columns, body: GraspedBody, cut: View | None = None
) -> tuple[Skin, list[GraspFrame]]:
    """The fingers' skin, and the positions of all bodies at each row.

    Args:
        fields: collection of the run's fields.
        config: of the run.
        result: its columns.
        body: the food.
        cut: from where fingers are seen that are cut open along their mid planes; None: they are
            whole.
    """
    mesh, displacements, further = read_steps(list_steps(fields))
    if cut is not None:
        rows = len(displacements)
        mesh, halves, sides = sawn(mesh, sum(further.values(), displacements), (1, -1))
        displacements, others = halves[:rows], iter(halves[rows:])
        further = {name: list(islice(others, rows)) for name in further}
    skin, half = extract_skin(mesh, mirror=False), halved(config, body)
    extent = float(skin.points[:, 0].min()), float(skin.points[:, 0].max())
    placement = placed(stands_of(config, body), extent, half=half)
    at_rest, frames = placement.positions(skin.points), placement.frames(skin.points)
    fingers = replace(skin, side=placement.which(skin.points).astype(float))
    if half:
        fingers = _completed(fingers, cut=cut is not None)
    images = (1.0, MIRROR) if half else (1.0,)
    shown: npt.NDArray[np.bool_] = np.ones(len(fingers.points), dtype=np.bool_)
    if cut is not None:
        side = np.concatenate([sides[skin.node] * factor for factor in (1, -1)[: len(images)]])
        depth = np.concatenate([at_rest * image for image in images]) @ cut.axes[2]
        shown = _farther(fingers, depth, side)
    moments = []
    for row, displacement in enumerate(displacements):
        turn = [float(result[f"object_turn_{axis}_deg"][row]) for axis in "xyz"]
        place = [float(result[f"object_{axis}_mm"][row]) for axis in "xyz"]
        turned = Rotation.from_rotvec(turn, degrees=True)
        food = turned.apply(body.surface.points) + place
        table = float(result["table_z_mm"][row])
        values = {
            name: np.tile(field[row][skin.node], len(images))[shown]
            for name, field in further.items()
        }
        moved = to_world(frames, displacement[skin.node])
        places, ways = (
            np.concatenate([vectors * image for image in images])[shown]
            for vectors in (at_rest + moved, moved)
        )
        time_s, pressure = (float(result[name][row]) for name in (TIME.name, PRESSURE.name))
        said = label(time_s, pressure, str(result["branch"][row]))
        moments.append(GraspFrame(places, food, table, ways, values, time_s, said))
    return fingers if cut is None else fingers.part(shown), moments


def _farther(skin: Skin, depth: Floats, sides: Floats) -> npt.NDArray[np.bool_]:
    """Which points belong to the half of their finger that is farther from the camera."""
    mine = np.zeros(len(sides), dtype=bool)
    for finger in np.unique(skin.side):
        halves = [(skin.side == finger) & (sides == side) for side in (1.0, -1.0)]
        mine |= min(halves, key=lambda half: float(depth[half].mean()))
    return mine


def _completed(skin: Skin, *, cut: bool = False) -> Skin:
    """Half a thumb and finger B with their mirror images; a cut thumb keeps its section."""
    section = (np.abs(skin.points[:, 1]) < IN_PLANE_MM) & (skin.side == 0) & (not cut)

    def both(parts: Ints) -> Ints:
        kept = parts[~section[parts].all(axis=1)]
        return np.concatenate([kept, kept[:, ::-1] + len(skin.points)])

    return Skin(
        np.concatenate([skin.points, skin.points * MIRROR]),
        np.concatenate([skin.node, skin.node]),
        np.concatenate([skin.side, np.where(skin.side == 0, 0.0, 2.0)]),
        both(skin.triangles),
        both(skin.edges),
        both(skin.creases),
    )


def _pictures(
    skin: Skin,
    body: GraspedBody,
    moments: Sequence[GraspFrame],
    config: Config,
    colour_by: Colour,
    turn_deg: float = 0.0,
) -> Pictures:
    """One picture for each moment; the table stands still, and the camera may turn around it."""
    views = VIEW.turning(turn_deg, len(moments))
    lift = [np.array([0.0, 0.0, -moment.table_mm]) for moment in moments]
    table = _table(moments)
    seen = [
        np.concatenate([moment.skin + by, moment.food + by, np.asarray(table.points)])
        for moment, by in zip(moments, lift, strict=True)
    ]
    focuses, size_mm, far = framing(seen, views)
    width_mm, height_mm = MARGIN * size_mm
    values, colours = _values(skin, moments, colour_by), colour_map(colour_by)
    range_, open_ended = colour_range(values, colour_by)
    if colour_by == "none":  # by the number of the finger
        range_, colours = (0.0, 2.0), ListedColormap(COLOURS)
    with stage(int(np.ceil(HEIGHT_PX * width_mm / height_mm)), HEIGHT_PX) as plotter:
        fingers = PaintedSkin(plotter, skin, values[0], colours, range_)
        creases = segments_of(moments[0].skin, skin.creases)
        plotter.add_mesh(creases, color=INK, line_width=1.2, opacity=0.6, lighting=False)
        food: Any = body.surface.polydata()
        plotter.add_mesh(food, color=config.food.shape.colour, smooth_shading=True, ambient=0.3)
        plotter.add_mesh(table, color=PALE, ambient=0.4)
        bodies = [food, fingers.surface]
        shadows = [mesh.copy() for mesh in bodies]
        for shadow in shadows:
            plotter.add_mesh(shadow, color=SHADE, lighting=False)
        least, most = np.array(table.bounds).reshape(3, 2).T
        least[2] = most[2] = most[2] + 0.2  # just above the table, which light from above meets
        images = []
        for moment, by, value, view, focus in zip(
            moments, lift, values, views, focuses, strict=True
        ):
            fingers.show(moment.skin + by, value)
            creases.points = moment.skin + by + 0.25 * view.axes[2]
            food.points = moment.food + by
            for shadow, body_above in zip(shadows, bodies, strict=True):
                shadow.points = np.clip(body_above.points, least, most)
            aim(plotter, focus, view, far=far, height_mm=height_mm)
            images.append(shot(plotter))
    labels = [moment.label for moment in moments]
    fixed = None if turn_deg else VIEW
    return Pictures(images, labels, HEIGHT_PX / height_mm, fixed, colour_by, range_, open_ended)


def _values(skin: Skin, moments: Sequence[GraspFrame], colour_by: Colour) -> list[Floats]:
    """Values that colour the fingers at each moment, at points or for triangles."""
    if colour_by == "none":
        return [skin.side for _ in moments]
    if colour_by == MOVED.name:
        return [np.linalg.norm(moment.displacement, axis=1) for moment in moments]
    if colour_by not in (fields := moments[0].fields):
        allowed = ", ".join([MOVED.name, *fields, "none"])
        raise ValueError(f"--colour-by {colour_by}: not in the fields; allowed: {allowed}")
    values = [moment.fields[colour_by] for moment in moments]
    if colour_by == INSIDE.name:
        return [skin.on_walls(value, mid_plane(skin.points)) for value in values]
    return values


def _table(moments: Sequence[GraspFrame]) -> Any:
    """A slab below the food, a little wider than it."""
    food = moments[0].food
    low, high = food.min(axis=0) - AROUND_MM, food.max(axis=0) + AROUND_MM
    return pv.Box((low[0], high[0], low[1], high[1], -4.0, 0.0))
