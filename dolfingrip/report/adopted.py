"""The picture of an adopted part: each group in its colour, from outside and cut open."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from dolfingrip.charts.theme import BLUE, DPI, GREEN, INK, ORANGE, PURPLE, figure_theme, save
from dolfingrip.meshes import groups
from dolfingrip.meshes.solid import SolidMesh
from dolfingrip.report.layout import place_pictures
from dolfingrip.report.scene import Image, View, aim, framing, shot, stage, surface_of

COLOURS: Final = {
    groups.CLAMP: INK,
    groups.TIP: GREEN,
    groups.SKIN: "#D9D6CF",
    groups.SYMMETRY: "#F0E442",
}
"""Colour of each group that is no cavity."""

CAVITIES: Final = (
    ORANGE, BLUE, PURPLE, "#E69F00", "#56B4E9", "#882255", "#44AA99", "#999933",
)  # fmt: skip
"""Colours of cavities, which come again where there are more."""


def _colours(mesh: SolidMesh) -> dict[str, str]:
    """Colour of each group of the mesh."""
    hollows = groups.cavities(mesh.facets)
    colours = {**COLOURS, **dict(zip(hollows, cycle(CAVITIES), strict=False))}
    return {name: colour for name, colour in colours.items() if name in mesh.facets}


WORDS: Final = {groups.CLAMP: "clamp (held)", groups.TIP: "tip (angle)", groups.SKIN: "skin",
                groups.SYMMETRY: "symmetry plane"}  # fmt: skip
"""Words for groups whose name says too little."""

OUTSIDE, INSIDE, BACK = View(35.0, 14.0), View(0.0, 0.0), View(-145.0, -30.0)
"""Cameras: from the front, onto the cut y = 0, from the back and below."""

HEIGHT_PX: Final = 1100

LABEL_IN: Final = 1.5
"""Width, in inches, that a picture's label needs."""


def draw(mesh: SolidMesh, out: Path, title: str) -> Path:
    """Write a PNG: from the front, cut open in y = 0, and from the back.

    Args:
        mesh: half or whole, in the finger's frame.
        out: file.
        title: text above.
    """
    surface = _surface(mesh)
    full = surface
    if groups.SYMMETRY in mesh.facets:
        image = surface.reflect((0, 1, 0), point=(0, 0, 0))
        full = surface.merge(image)
        full = full.extract_cells(full["symmetry"] == 0)
    half = surface if full is not surface else surface.clip((0, -1, 0), origin=(0, 0, 0))
    half = half.extract_cells(half["symmetry"] == 0)
    pictures = [_shot(full, OUTSIDE), _shot(half, INSIDE), _shot(full, BACK)]
    labels = ["from the front", "cut open in y = 0", "from the back, below"]
    return _save(pictures, labels, _colours(mesh), out, title)


def _surface(mesh: SolidMesh) -> Any:
    """Triangles or quadrilaterals of all groups, each with its colour."""
    facets, colours, plane = [], [], []
    colour_of = _colours(mesh)
    for name, group in mesh.facets.items():
        corners = group[:, : mesh.shape.facet_corners]
        facets.append(corners)
        rgb = [int(colour_of[name][i : i + 2], 16) for i in (1, 3, 5)]
        colours.append(np.tile(np.array(rgb, dtype=np.uint8), (len(corners), 1)))
        plane.append(np.full(len(corners), int(name == groups.SYMMETRY)))
    every = np.concatenate(facets)
    surface = surface_of(mesh.points, every)
    surface["rgb"] = np.concatenate(colours)
    surface["symmetry"] = np.concatenate(plane)
    return surface


def _shot(surface: Any, view: View) -> Image:
    """A picture of the surface, trimmed to what it shows."""
    (focus,), size_mm, far = framing([np.asarray(surface.points)], [view])
    width, height = 1.04 * size_mm
    with stage(max(round(HEIGHT_PX * width / height), 60), HEIGHT_PX) as plotter:
        plotter.add_mesh(surface, scalars="rgb", rgb=True, ambient=0.5, diffuse=0.55, specular=0.0)
        edges = surface.extract_surface(algorithm="dataset_surface").extract_feature_edges(
            35.0, manifold_edges=False, non_manifold_edges=False
        )
        if edges.n_points:
            edges.points = np.asarray(edges.points) + 0.002 * far * view.axes[2]
            plotter.add_mesh(edges, color=INK, line_width=1.6, lighting=False)
        aim(plotter, focus, view, far=far, height_mm=height)
        return shot(plotter)


def _save(
    pictures: list[Image], labels: list[str], colours: Mapping[str, str], out: Path, title: str
) -> Path:
    lacks = [max(round(LABEL_IN * DPI) - picture.shape[1], 0) for picture in pictures]
    pictures = [
        np.pad(picture, ((0, 0), (lack // 2, lack - lack // 2), (0, 0)), constant_values=255)
        for picture, lack in zip(pictures, lacks, strict=True)
    ]
    widths = [picture.shape[1] / DPI for picture in pictures]
    height, gap, top, legend = HEIGHT_PX / DPI, 0.35, 0.75, 1.65
    size = (sum(widths) + gap * (len(pictures) + 1) + legend, height + top + 0.2)
    with figure_theme():
        figure = Figure(figsize=size, dpi=DPI)
        FigureCanvasAgg(figure)
        place_pictures(figure, pictures, labels, (gap, 0.1), gap, below_top_in=0.5, fontsize=8)
        figure.text(gap / size[0], 1 - 0.12 / size[1], title, va="top", fontweight="bold")
        patches = [
            Patch(facecolor=colour, edgecolor=INK, lw=0.5,
                  label=WORDS.get(name, name.replace("_", " ")))
            for name, colour in colours.items() if name != groups.SYMMETRY
        ]  # fmt: skip
        figure.legend(handles=patches, loc="center right", fontsize=8)
        save(figure, out)
    return out
