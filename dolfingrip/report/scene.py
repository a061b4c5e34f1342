"""Pictures of the deformed shapes of one finger, with one light, one camera, one colour range.

Only shapes are drawn here; all lettering is set afterwards around the picture
(:mod:`dolfingrip.report.layout`), where it can neither cover the finger nor be clipped.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import pyvista as pv
from matplotlib.colors import Colormap

from dolfingrip.charts.theme import INK, ORANGE, PALE, scene_theme
from dolfingrip.report.beside import ALONE, Beside, Plate
from dolfingrip.report.skin import Floats, Ints, Skin

Image = npt.NDArray[np.uint8]


CLAMP_MM: Final = 8.0
"""Height of the block drawn as the clamp."""

MARGIN_MM: Final = 2.0
"""White around everything that is drawn."""

LIFT_MM: Final = 0.25
"""How far lines are drawn in front of the surface."""

AROUND_MM: Final = 3.0
"""How far clamp and plate stand out beyond the finger."""

SLAB_MM: Final = 3.0
"""Thickness of the plate."""


@dataclass(frozen=True)
class View:
    """A parallel projection; a finger has its clamp above (−z is up), bending to the right.

    Attributes:
        azimuth_deg: turn of the camera from the side view (seen from −y) towards the bellows.
        elevation_deg: rise of the camera above the horizontal.
        up: 1 where z is up, −1 where −z is.
    """

    azimuth_deg: float = 32.0
    elevation_deg: float = 10.0
    up: float = -1.0

    def turning(self, turn_deg: float, count: int) -> list[View]:
        """Views of a camera that turns about the vertical, with this view amid them.

        Args:
            turn_deg: angle between the first and the last view.
            count: number of views.
        """
        turns = turn_deg * (np.linspace(-0.5, 0.5, count) if count > 1 else np.zeros(count))
        return [replace(self, azimuth_deg=self.azimuth_deg + float(turn)) for turn in turns]

    @property
    def axes(self) -> Floats:
        """Unit vectors to the right, upwards and towards the camera, shape (3, 3)."""
        a, e = np.radians([self.azimuth_deg, self.elevation_deg])
        towards = np.array([np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), self.up * np.sin(e)])
        right = np.cross([0.0, 0.0, self.up], towards)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(towards, right), towards])


def draw_shapes(
    skin: Skin,
    displacements: Sequence[Floats],
    values: Sequence[Floats],
    *,
    range_: tuple[float, float],
    colour_map: Colormap,
    view: View,
    turn_deg: float = 0.0,
    height_px: int,
    beside: Beside = ALONE,
) -> tuple[list[Image], float]:
    """Draw several deformed shapes of the finger with one camera.

    Args:
        skin: surface of the finger.
        displacements: nodal displacements in mm of each shape, each an array (nodes, 3).
        values: to colour each shape by, at the skin's points or for its triangles.
        range_: values at the ends of the colour map.
        colour_map: Matplotlib's object.
        view: direction of the camera; it frames the union of all shapes.
        turn_deg: angle by which the camera turns from the first shape to the last.
        height_px: height of the pictures; the width follows from the content.
        beside: what else is drawn.

    Returns:
        Pictures of shape (height, width, 3), and how many pixels a millimetre takes.
    """
    shapes = [skin.move(displacement) for displacement in displacements]
    fixtures = [(_clamp(skin), 1.0)]
    if beside.plate is not None:
        fixtures.append((_slab(skin, beside.plate), 0.45))
    views, towards = view.turning(turn_deg, len(shapes)), view.axes[2]
    # in front of the finger's side, so that they are not hidden
    side, lift = skin.points[:, 1].min(), 2 * LIFT_MM * towards
    lines = [np.insert(curve, 1, side, axis=1) + lift for curve in beside.curves]
    food = [] if beside.food is None else [beside.food.points]
    blocks = (np.asarray(block.points) for block, _ in fixtures)
    still = np.concatenate([*blocks, *lines, *food])
    seen = [np.concatenate([shape, still]) for shape in shapes]
    focuses, size_mm, far = framing(seen, views)
    width_mm, height_mm = size_mm + 2 * MARGIN_MM
    per_mm = height_px / height_mm

    with stage(int(np.ceil(width_mm * per_mm)), height_px) as plotter:
        painted = PaintedSkin(plotter, skin, values[0], colour_map, range_)
        edges, creases = (segments_of(skin.points, pairs) for pairs in (skin.edges, skin.creases))
        plotter.add_mesh(edges, color=INK, line_width=1.0, opacity=0.22, lighting=False)
        plotter.add_mesh(creases, color=INK, line_width=2.2, opacity=0.85, lighting=False)
        for block, opacity in fixtures:
            plotter.add_mesh(block, color=PALE, opacity=opacity, ambient=0.35)
            plotter.add_mesh(block.extract_feature_edges(30), color=INK, line_width=1.5)
        for line in lines:
            target = pv.lines_from_points(line)
            plotter.add_mesh(target, color=ORANGE, line_width=6.0, lighting=False)
        if beside.food is not None:
            body = beside.food.polydata()
            plotter.add_mesh(body, color=beside.food_colour, smooth_shading=True, ambient=0.35)
        pictures = []
        for moved, value, at, focus in zip(shapes, values, views, focuses, strict=True):
            painted.show(moved, value)
            # Lines drawn in the surface would flicker, so they are drawn a little in front of it.
            edges.points = creases.points = moved + LIFT_MM * at.axes[2]
            aim(plotter, focus, at, far=far, height_mm=height_mm)
            pictures.append(shot(plotter))
    return pictures, per_mm


def framing(seen: Sequence[Floats], views: Sequence[View]) -> tuple[list[Floats], Floats, float]:
    """Place cameras so that all pictures have one scale, and what turns keeps its place.

    Args:
        seen: points (mm) that each picture shows.
        views: of each picture.

    Returns:
        The point that each camera looks at; width and height (mm) of what all pictures show; and
        a distance (mm) from which nothing lies behind the camera.
    """
    ends = np.array([[points.min(axis=0), points.max(axis=0)] for points in seen])
    low, high = ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
    about = (low + high) / 2
    flat = [(points - about) @ view.axes[:2].T for points, view in zip(seen, views, strict=True)]
    least = np.min([plane.min(axis=0) for plane in flat], axis=0)
    most = np.max([plane.max(axis=0) for plane in flat], axis=0)
    focuses = [about + (least + most) / 2 @ view.axes[:2] for view in views]
    return focuses, most - least, 3 * float((high - low).max())


class PaintedSkin:
    """A skin on a stage that moves and changes its colours; it is sharp at creases.

    Args:
        plotter: of the stage.
        skin: at rest.
        values: to colour it by, at its points or for its triangles.
        colour_map: Matplotlib's object.
        range_: values at the ends of the colour map.

    Attributes:
        surface: as pyvista draws it.
    """

    def __init__(
        self,
        plotter: pv.Plotter,
        skin: Skin,
        values: Floats,
        colour_map: Colormap,
        range_: tuple[float, float],
    ) -> None:
        self.surface, self._source = _shaded(skin)
        self.show(skin.points, values)
        plotter.add_mesh(
            self.surface,
            scalars="value",
            cmap=colour_map,
            clim=range_,
            show_scalar_bar=False,
            ambient=0.56,
            diffuse=0.54,
            specular=0.03,
        ).prop.interpolation = "Phong"

    def show(self, points: Floats, values: Floats) -> None:
        """Move its points, shape (points, 3), and colour it by values as those at the start."""
        surface = self.surface
        surface.points = points[self._source]
        if len(values) == surface.n_cells:
            surface.cell_data["value"] = values
        else:
            surface.point_data["value"] = values[self._source]
        surface.point_data["Normals"] = _normals(surface)


@contextmanager
def stage(width_px: int, height_px: int) -> Iterator[pv.Plotter]:
    """Open a window off screen, with the light of all pictures, and close it."""
    plotter = pv.Plotter(
        off_screen=True,
        theme=scene_theme(),
        lighting="light kit",
        window_size=[width_px, height_px],
    )
    try:
        yield plotter
    finally:
        plotter.close()
        plotter.deep_clean()


def shot(plotter: pv.Plotter) -> Image:
    """Take a picture of what stands on a stage."""
    plotter.render()
    return np.array(plotter.screenshot(return_img=True))[..., :3]


def aim(plotter: pv.Plotter, focus: Floats, view: View, *, far: float, height_mm: float) -> None:
    """Point a camera at ``focus`` from ``far`` (mm) away; its picture is ``height_mm`` high."""
    _, up, towards = view.axes
    plotter.camera_position = [focus + far * towards, focus, up]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = height_mm / 2
    plotter.camera.clipping_range = (0.01 * far, 2 * far)


def split_at_creases(skin: Skin) -> tuple[Ints, Ints]:
    """A skin's points doubled along creases: the skin's point behind each, and the triangles.

    The undeformed shape decides where it is split: a crease stays sharp, a smooth wall smooth.

    Returns:
        Shapes (points,) and (triangles, 3).
    """
    surface, source = _shaded(skin)
    return source, np.asarray(surface.regular_faces, dtype=np.int64)


def _shaded(skin: Skin) -> tuple[Any, Ints]:
    """The surface split as by :func:`split_at_creases`, and the skin's point behind each."""
    surface = surface_of(skin.points, skin.triangles)
    surface["source"] = np.arange(len(skin.points))
    split = surface.compute_normals(
        cell_normals=False, split_vertices=True, feature_angle=35.0, consistent_normals=False
    )
    return split, np.asarray(split["source"], dtype=np.int64)


def _normals(surface: Any) -> Floats:
    """Area-weighted point normals of a triangulated surface, shape (points, 3)."""
    points = np.asarray(surface.points, dtype=np.float64)
    triangles = surface.regular_faces
    a, b, c = (points[triangles[:, i]] for i in range(3))
    of_face = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for i in range(3):
        np.add.at(normals, triangles[:, i], of_face)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.maximum(lengths, 1e-30))


def segments_of(points: Floats, segments: Ints) -> Any:
    """Lines between points, as pyvista draws them."""
    return pv.PolyData(points.copy(), lines=np.insert(segments, 0, 2, axis=1).ravel())


def surface_of(points: Floats, facets: Ints) -> Any:
    """Facets with equal numbers of corners, as pyvista draws them."""
    return pv.PolyData(points, faces=np.insert(facets, 0, facets.shape[1], axis=1).ravel())


def _clamp(skin: Skin) -> Any:
    low, high = clamp(skin)
    return pv.Box([end for ends in zip(low, high, strict=True) for end in ends])


def clamp(skin: Skin) -> tuple[Floats, Floats]:
    """Lowest and highest corner (mm) of a block above the clamped face z = 0, larger than it."""
    z = skin.points[:, 2]
    held = skin.points[z < z.min() + 1e-6 * np.ptp(z)]
    low, high = held.min(axis=0) - AROUND_MM, held.max(axis=0) + AROUND_MM
    low[2], high[2] = z.min() - CLAMP_MM, z.min()
    return low, high


def _slab(skin: Skin, plate: Plate) -> Any:
    """A slab 3 mm thick behind the plate's face, around the point nearest to the tip."""
    half_mm, axes, centre = slab(skin.points.min(axis=0), skin.points.max(axis=0), plate)
    ends = ((-size, size) for size in half_mm[1:])
    block = pv.Box((-half_mm[0], 0.0, *(end for both in ends for end in both)))
    block.points = centre + np.asarray(block.points) @ axes
    return block


def slab(low: Floats, high: Floats, plate: Plate) -> tuple[Floats, Floats, Floats]:
    """Place a slab behind the plate's face, around the point nearest to the tip.

    Args:
        low: least coordinates of the unloaded finger (mm).
        high: largest coordinates of it (mm).
        plate: whose face the slab has.

    Returns:
        Its thickness and half of its sides (mm), its axes as rows, and the centre of its face (mm).
    """
    normal = np.asarray(plate.normal, dtype=np.float64)
    normal /= np.linalg.norm(normal)
    tip = np.array([low[0], 0.0, high[2]])
    centre = tip - ((tip - np.asarray(plate.point_mm)) @ normal) * normal
    # The plate is tilted about y alone, so one of its edges stays parallel to y.
    across = np.array([0.0, 1.0, 0.0])
    if abs(normal[1]) > 0.9:
        across = np.array([0.0, 0.0, 1.0])
    along = np.cross(normal, across)
    along /= np.linalg.norm(along)
    wide = float(np.abs([low[1], high[1]]).max()) + AROUND_MM
    sizes = np.array([SLAB_MM, wide, plate.contact_length_mm])
    return sizes, np.array([normal, np.cross(along, normal), along]), centre
