"""Renders of the deformed finger at chosen pressures, without a display.

>>> render_strip(run / "fields.pvd", [0, 100, 200], run / "poses.png")  # doctest: +SKIP

Under MPI these functions are for one rank (rank 0): they read all pieces from disk and do not
communicate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from dolfingrip.report.columns import Columns
from dolfingrip.report.fields import (
    FieldMesh,
    find_steps,
    list_steps,
    load_result,
    read_grid,
    read_mesh,
    read_point_data,
)
from dolfingrip.report.layout import save_pictures, trim
from dolfingrip.report.scene import Image, Plate, View, draw_poses
from dolfingrip.report.skin import Floats, extract_skin
from dolfingrip.report.theme import DPI, colour_map

__all__ = ["Plate", "View", "render_finger", "render_section", "render_strip"]

Quantity = Literal["displacement", "stretch"]

LABELS = {
    "displacement": "Displacement magnitude (mm)",
    "stretch": "Largest principal stretch (–)",
}
SIDE, CUT = View(), View(azimuth_deg=0.0, elevation_deg=0.0)


def render_finger(
    fields: Path,
    pressures_kPa: Sequence[float],
    out: Path,
    *,
    colour_by: Quantity = "displacement",
    result: Columns | Path | None = None,
    branch: str = "loading",
    mirror: bool = True,
    plate: Plate | None = None,
    height_in: float = 5.0,
    stem: str = "finger",
) -> list[Path]:
    """One picture of the deformed finger for each pressure, all with one camera and scale.

    Parameters
    ----------
    fields
        ParaView collection whose steps are the rows of the result, in order, with point data
        ``displacement_mm`` (vector) and ``principal_stretch`` (scalar, –).
    pressures_kPa
        Pressures to draw, each one a row of the result.
    out
        Folder to write to; made where missing.
    colour_by
        ``displacement`` (magnitude, mm) or ``stretch`` (largest principal stretch, –).
    result
        Columns of the result, or its CSV file; ``result.csv`` beside ``fields`` where None.
    branch
        ``loading`` or ``unloading``, where both have the pressure.
    mirror
        Complete a half finger y ≥ 0; without it the half is drawn, cut open towards the reader.
    plate
        Force sensor to draw.
    height_in
        Height of the finger's frame in inches, at 300 dots per inch.
    stem
        Files are called ``<stem>_<pressure>kPa.png``.

    Returns
    -------
    The files, in the order of the pressures.

    Raises
    ------
    ValueError
        One line: a pressure that is not in the results (with those that are), steps and rows
        that differ in number, or fields that are missing or of the wrong kind.
    """
    film = _film(
        fields,
        pressures_kPa,
        colour_by=colour_by,
        result=result,
        branch=branch,
        mirror=mirror,
        plate=plate,
        height_in=height_in,
    )
    return [
        film.save([picture], [label], out / f"{stem}_{label.replace(' ', '')}.png")
        for picture, label in zip(film.pictures, film.labels, strict=True)
    ]


def render_strip(
    fields: Path,
    pressures_kPa: Sequence[float],
    out: Path,
    *,
    colour_by: Quantity = "displacement",
    result: Columns | Path | None = None,
    branch: str = "loading",
    mirror: bool = True,
    plate: Plate | None = None,
    height_in: float = 4.0,
) -> Path:
    """The poses at the chosen pressures side by side in one PNG with one shared scale.

    Parameters and errors are those of :func:`render_finger`, but ``out`` is a file.
    """
    film = _film(
        fields,
        pressures_kPa,
        colour_by=colour_by,
        result=result,
        branch=branch,
        mirror=mirror,
        plate=plate,
        height_in=height_in,
    )
    return film.save([trim(picture, DPI // 12) for picture in film.pictures], film.labels, out)


def render_section(
    fields: Path,
    pressures_kPa: Sequence[float],
    out: Path,
    *,
    colour_by: Quantity = "stretch",
    result: Columns | Path | None = None,
    branch: str = "loading",
    plate: Plate | None = None,
    height_in: float = 4.0,
) -> Path:
    """The cut through the symmetry plane with the cavity, poses side by side in one PNG.

    Parameters are those of :func:`render_finger`, but ``out`` is a file; fields of a whole
    finger are refused.
    """
    film = _film(
        fields,
        pressures_kPa,
        colour_by=colour_by,
        result=result,
        branch=branch,
        mirror=False,
        plate=plate,
        height_in=height_in,
        view=CUT,
    )
    return film.save([trim(picture, DPI // 12) for picture in film.pictures], film.labels, out)


@dataclass(frozen=True)
class _Film:
    """Pictures with all that their lettering needs."""

    pictures: list[Image]
    labels: list[str]
    px_per_mm: float
    view: View
    colour_by: Quantity
    range_: tuple[float, float]
    open_ended: bool

    def save(self, pictures: Sequence[Image], labels: Sequence[str], out: Path) -> Path:
        return save_pictures(
            pictures,
            labels,
            out,
            px_per_mm=self.px_per_mm,
            view=self.view,
            colour_map=colour_map(self.colour_by),
            range_=self.range_,
            scale_label=LABELS[self.colour_by],
            open_ended=self.open_ended,
        )


def _film(
    fields: Path,
    pressures_kPa: Sequence[float],
    *,
    colour_by: Quantity,
    result: Columns | Path | None,
    branch: str,
    mirror: bool,
    plate: Plate | None,
    height_in: float,
    view: View = SIDE,
) -> _Film:
    if colour_by not in LABELS:
        raise ValueError(f"colour_by = {colour_by}: allowed: {', '.join(LABELS)}")
    if not len(pressures_kPa):
        raise ValueError("pressures_kPa = []: allowed: at least one pressure")
    table, files = load_result(fields, result), list_steps(fields)
    rows = len(list(table["pressure_kPa"])) if "pressure_kPa" in table else len(files)
    if rows != len(files):
        raise ValueError(f"{fields}: {len(files)} steps, but the result has {rows} rows")
    steps = find_steps(table, pressures_kPa, branch)
    mesh, displacements, values = _read(fields, [files[step] for step in steps], colour_by)
    skin = extract_skin(mesh, mirror=mirror, cut=view is CUT)
    range_, open_ended = _range([value[skin.node] for value in values], colour_by)
    pictures, px_per_mm = draw_poses(
        skin,
        displacements,
        values,
        range_=range_,
        colour_map=colour_map(colour_by),
        view=view,
        height_px=round(height_in * DPI),
        plate=plate,
    )
    labels = [f"{pressure:g} kPa" for pressure in pressures_kPa]
    return _Film(pictures, labels, px_per_mm, view, colour_by, range_, open_ended)


def _read(
    fields: Path, files: Sequence[Path], colour_by: Quantity
) -> tuple[FieldMesh, list[Floats], list[Floats]]:
    """The mesh, and nodal displacements and colour values of each step asked for."""
    mesh: FieldMesh | None = None
    displacements, values = [], []
    for file in files:
        grid = read_grid(file)
        if mesh is None:
            mesh, count = read_mesh(grid), grid.n_points
        if grid.n_points != count:
            raise ValueError(f"{fields}: steps on different meshes")
        displacement = read_point_data(grid, "displacement_mm", mesh.source)
        displacements.append(displacement)
        values.append(
            np.linalg.norm(displacement, axis=1)
            if colour_by == "displacement"
            else read_point_data(grid, "principal_stretch", mesh.source)
        )
    assert mesh is not None
    return mesh, displacements, values


def _range(values: Sequence[Floats], colour_by: Quantity) -> tuple[tuple[float, float], bool]:
    """Ends of the colour scale, the same for all poses, and whether values exceed it."""
    every = np.concatenate(values)
    low = 0.0 if colour_by == "displacement" else 1.0
    highest = float(every.max())
    # Stretch peaks at sharp edges; a few nodes there would leave the rest in one colour.
    high = highest if colour_by == "displacement" else float(np.quantile(every, 0.995))
    if high - low < 1e-6:
        return (low, low + 1.0), False
    return (low, high), highest > 1.001 * high
