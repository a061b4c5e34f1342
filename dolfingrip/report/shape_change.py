"""Pictures of a descent: the finger before and after, and its section, also as text."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from dolfingrip.charts.theme import BLUE, DPI, INK, colour_map, figure_theme, save
from dolfingrip.meshes.cells import FACET_CORNERS
from dolfingrip.meshes.solid import Floats, Ints, SolidMesh
from dolfingrip.report import printable
from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.layout import save_pictures, trim
from dolfingrip.report.render import CUT, SIDE, STRIP_MARGIN_PX
from dolfingrip.report.scene import Image, View, draw_shapes
from dolfingrip.report.skin import Skin, extract_skin

HEIGHT_IN = 3.2

BLOCKS = " ▄▀█"
"""Characters by whether their lower and their upper half are solid."""


def _skin(mesh: SolidMesh, *, cut: bool) -> Skin:
    cells = mesh.cells[:, : mesh.shape.corners]
    return extract_skin(FieldMesh(mesh.points, cells, np.arange(len(mesh.points))), cut=cut)


def draw_change(start: SolidMesh, best: SolidMesh, labels: Sequence[str], out: Path) -> list[Path]:
    """Draw a finger before and after: ``finger.png`` and, of a half finger, ``section.png``.

    Args:
        start: the mesh before.
        best: the same mesh with moved points.
        labels: texts above the two.
        out: folder.
    """
    moved = best.points - start.points
    size = np.linalg.norm(moved, axis=1)
    shapes, values = [np.zeros_like(moved), moved], [np.zeros_like(size), size]
    range_ = (0.0, max(float(size.max()), 1e-3))
    views: list[tuple[str, View, bool]] = [("finger", SIDE, False)]
    if "symmetry" in start.facets:
        views.append(("section", CUT, True))
    written = []
    for name, view, cut in views:
        skin = _skin(start, cut=cut)
        images, per_mm = draw_shapes(
            skin,
            shapes,
            [value[skin.node] for value in values],
            range_=range_,
            colour_map=colour_map("displacement"),
            view=view,
            height_px=round(HEIGHT_IN * DPI),
        )
        trimmed: list[Image] = [trim(image, STRIP_MARGIN_PX) for image in images]
        written.append(
            save_pictures(
                trimmed,
                labels,
                out / f"{name}.png",
                px_per_mm=per_mm,
                view=view,
                colour_map=colour_map("displacement"),
                range_=range_,
                scale_label="Change of the shape (mm)",
            )
        )
    return written


def draw_section(mesh: SolidMesh, start: SolidMesh, title: str, file: Path) -> bool:
    """Draw the section y = 0 of a half finger over that of the start, in a moment.

    Args:
        mesh: of the design.
        start: the same mesh before.
        title: text above it.
        file: PNG.

    Returns:
        Whether there is a section to draw.
    """
    facets: Ints = mesh.facets.get("symmetry", np.empty((0, 3), dtype=np.int64))
    if not len(facets):
        return False
    facets = facets[:, : FACET_CORNERS[facets.shape[1]]]
    before, now = (shape.points[:, [2, 0]] for shape in (start, mesh))
    with figure_theme():
        both = np.concatenate([before[facets], now[facets]])
        low, high = both.min(axis=(0, 1)) - 2.0, both.max(axis=(0, 1)) + 2.0
        tall = 6.4 * (high[1] - low[1]) / (high[0] - low[0]) + 0.9
        figure = Figure(figsize=(6.4, tall), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        axes.add_collection(PolyCollection(list(now[facets]), fc=BLUE, ec=BLUE, lw=0.3, alpha=0.6))
        axes.add_collection(LineCollection(list(before[_rim(facets)]), color=INK, lw=0.8))
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.set(xlabel="z (mm)", ylabel="x (mm)")
        axes.set_title(title, fontsize=9)
        save(figure, file)
    return True


def section_text(mesh: SolidMesh, width: int = 64) -> str:
    """The section y = 0 of a half finger, clamp on the left, contact face below.

    Args:
        mesh: half finger of hexahedra.
        width: number of characters in a line.
    """
    facets: Ints = mesh.facets.get("symmetry", np.empty((0, 4), dtype=np.int64))[:, :4]
    if not len(facets):
        return ""
    seen: Floats = mesh.points[facets][:, :, [2, 0]]
    low, high = seen.reshape(-1, 2).min(axis=0), seen.reshape(-1, 2).max(axis=0)
    cell = (high[0] - low[0]) / width
    rows = 2 * max(1, round((high[1] - low[1]) / cell / 2))
    across = low[0] + cell * (np.arange(width) + 0.5)
    up = low[1] + (high[1] - low[1]) / rows * (np.arange(rows) + 0.5)
    places = np.stack(np.meshgrid(across, up, indexing="xy"), axis=-1)
    solid = np.zeros((rows, width), dtype=bool)
    for corners in seen:
        edges = np.roll(corners, -1, axis=0) - corners
        away = places[:, :, None] - corners
        turn = edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0]
        solid |= (turn >= 0).all(axis=2) | (turn <= 0).all(axis=2)
    pairs = solid[::2].astype(int) + 2 * solid[1::2]
    return "\n".join("".join(BLOCKS[pair] for pair in row) for row in pairs[::-1])


def _rim(facets: Ints) -> Ints:
    """Edges that one facet alone has, (k, 2)."""
    edges = np.stack([facets, np.roll(facets, -1, axis=1)], axis=-1).reshape(-1, 2)
    distinct, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    return np.asarray(distinct[count == 1])


def write_stl(mesh: SolidMesh, file: Path) -> None:
    """Write the whole finger's surface, its cavity included, as STL in mm.

    Args:
        mesh: of the finger, half or whole.
        file: target.

    Raises:
        WriteError: one line.
    """
    skin = _skin(mesh, cut=False)
    printable.write_stl(skin.points, skin.triangles, file)
