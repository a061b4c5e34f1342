"""Pictures of a descent: the finger before and after, and how it went."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from dolfingrip.meshes.cells import FACET_CORNERS
from dolfingrip.meshes.solid import Floats, Ints, SolidMesh
from dolfingrip.report import printable
from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.layout import save_pictures, trim
from dolfingrip.report.render import CUT, SIDE, STRIP_MARGIN_PX
from dolfingrip.report.scene import Image, View, draw_shapes
from dolfingrip.report.skin import Skin, extract_skin
from dolfingrip.report.theme import (
    BLUE,
    DPI,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    colour_map,
    figure_theme,
    save,
)

HEIGHT_IN = 3.2


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
        images, per_mm = draw_shapes(
            _skin(start, cut=cut),
            shapes,
            values,
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
    before, now = (each.points[:, [2, 0]] for each in (start, mesh))
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


def _rim(facets: Ints) -> Ints:
    """(k, 2) edges that one facet alone has."""
    edges = np.stack([facets, np.roll(facets, -1, axis=1)], axis=-1).reshape(-1, 2)
    found, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    return np.asarray(found[count == 1])


def write_stl(mesh: SolidMesh, file: Path) -> None:
    """Write the whole finger's surface, its cavity included, as STL in mm."""
    skin = _skin(mesh, cut=False)
    printable.write_stl(skin.points, skin.triangles, file)


@dataclass(frozen=True)
class Course:
    """How a descent went; all arrays of shape (designs,).

    Attributes:
        title: of the objective, with its unit.
        simulations: load paths so far.
        objective: NaN where the solve failed.
        accepted: whether the next steps began there.
        limits: for each limit's text the share of its size that is left, below 0 where broken.
    """

    title: str
    simulations: Sequence[int]
    objective: Sequence[float]
    accepted: Sequence[bool]
    limits: Mapping[str, Sequence[float]]


def plot_course(course: Course, file: Path) -> None:
    """Plot objective and limits against simulations."""
    at, value = np.array(course.simulations), np.array(course.objective, dtype=float)
    taken, failed = np.array(course.accepted, dtype=bool), np.isnan(value)
    panels = 2 if course.limits else 1
    with figure_theme():
        figure = Figure(figsize=(5.0 * panels, 3.8), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(1, panels, squeeze=False)[0]
        axes[0].plot(at[taken], value[taken], "o-", color=BLUE, label="accepted")
        rejected = ~taken & ~failed
        if rejected.any():
            axes[0].plot(
                at[rejected],
                value[rejected],
                "x",
                color=ORANGE,
                label="not accepted: step shortened",
            )
        for i, place in enumerate(at[failed]):
            axes[0].axvline(place, color=GREY, ls=":", label="" if i else "solve failed")
        axes[0].set(xlabel="Load paths simulated", ylabel=course.title)
        axes[0].legend()
        colours = [BLUE, ORANGE, GREEN, PURPLE, INK, GREY]
        for i, (name, left) in enumerate(course.limits.items()):
            style = "-" if i < len(colours) else "--"
            axes[1].plot(
                at[taken],
                100 * np.array(left)[taken],
                f"o{style}",
                ms=3,
                color=colours[i % len(colours)],
                label=name,
            )
        if course.limits:
            axes[1].axhline(0, color=INK, lw=0.8)
            axes[1].set(xlabel="Load paths simulated", ylabel="Left to the limit (% of it)")
            axes[1].legend(fontsize=7)
        for panel in axes:
            panel.xaxis.set_major_locator(MaxNLocator(integer=True))
        save(figure, file)


@dataclass(frozen=True)
class Band:
    """A front with its uncertainty.

    Attributes:
        against, title: of the axes.
        limit, mean, deviation: shape (levels,), the front.
        simulated_at, simulated: shape (n,), designs that were simulated.
        areas, unsure: hypervolume, and largest deviation by the front's range, after simulations.
        places: for each parameter its best value, lowest and highest one, shape (levels, 3), in
            its range, 0 to 1.
    """

    against: str
    title: str
    limit: Floats
    mean: Floats
    deviation: Floats
    simulated_at: Floats
    simulated: Floats
    areas: Sequence[float]
    unsure: Sequence[float]
    places: Mapping[str, Floats]


MOST_PLACES = 4
"""Largest number of parameters whose places are drawn: those that change most."""


def plot_band(band: Band, file: Path) -> None:
    """Plot a front with its deviations, its designs' places, and how it settled."""
    with figure_theme():
        figure = Figure(figsize=(13.5, 3.8), layout="constrained")
        FigureCanvasAgg(figure)
        left, middle, right = figure.subplots(1, 3)
        moving = sorted(band.places, key=lambda key: -float(np.ptp(band.places[key][:, 0])))
        for colour, key in zip((BLUE, ORANGE, GREEN, INK), moving[:MOST_PLACES], strict=False):
            place = band.places[key]
            middle.fill_between(band.limit, place[:, 1], place[:, 2], color=colour, alpha=0.2, lw=0)
            middle.plot(band.limit, place[:, 0], color=colour, label=key)
        middle.set(
            xlabel=f"{band.against} at most",
            ylabel="Best design, part of its range, and 90 % interval",
            ylim=(-0.03, 1.03),
        )
        middle.legend()
        low, high = band.mean - 2 * band.deviation, band.mean + 2 * band.deviation
        left.fill_between(
            band.limit, low, high, color=BLUE, alpha=0.25, lw=0, label="two standard deviations"
        )
        left.plot(band.limit, band.mean, color=BLUE, label="front")
        left.plot(
            band.simulated_at, band.simulated, "D", color=INK, mfc="none", ms=4, label="simulated"
        )
        left.set(xlabel=f"{band.against} at most", ylabel=band.title)
        left.legend()
        count = len(band.simulated)
        at = np.arange(count - len(band.areas) + 1, count + 1)
        apart = np.abs(np.array(band.areas[:-1]) / band.areas[-1] - 1)
        right.semilogy(
            at,
            100 * np.array(band.unsure),
            "o-",
            color=BLUE,
            ms=3,
            label="largest deviation (% of the front's range)",
        )
        right.semilogy(
            at[:-1],
            100 * np.maximum(apart, 1e-6),
            "s-",
            color=ORANGE,
            ms=3,
            label="hypervolume, from the last one (%)",
        )
        right.set(xlabel="Load paths simulated", ylabel="%")
        right.xaxis.set_major_locator(MaxNLocator(integer=True))
        right.legend()
        save(figure, file)
