"""Pictures of the deformed shapes of one finger, with one light, one camera, one colour range.

Only shapes are drawn here; all lettering is set afterwards around the picture
(:mod:`dolfingrip.report.layout`), where it can neither cover the finger nor be clipped.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import pyvista as pv
from matplotlib.colors import Colormap

from dolfingrip.charts.theme import INK, PALE, scene_theme
from dolfingrip.report.skin import Floats, Ints, Skin

Image = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class SceneSizes:
    """Sizes of what is drawn around a finger.

    Attributes:
        clamp_mm: height of the block drawn as the clamp.
        margin_mm: white around everything that is drawn.
        lift_mm: how far lines are drawn in front of the surface.
    """

    clamp_mm: float = 8.0
    margin_mm: float = 2.0
    lift_mm: float = 0.25


SIZES: Final = SceneSizes()


@dataclass(frozen=True)
class Plate:
    """The force sensor as drawn.

    Attributes:
        point_mm: any point of its face.
        normal: of its face, towards the finger; any length but zero.
        contact_length_mm: length of the finger that faces it, from the tip; it is drawn twice as
            long, half of it beyond the tip.
    """

    point_mm: Sequence[float]
    normal: Sequence[float] = (1.0, 0.0, 0.0)
    contact_length_mm: float = 10.0


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
    height_px: int,
    plate: Plate | None = None,
) -> tuple[list[Image], float]:
    """Draw several deformed shapes of the finger with one camera.

    Args:
        skin: surface of the finger.
        displacements: nodal displacements in mm of each shape, each an array (nodes, 3).
        values: nodal values to colour each shape by, arrays (nodes,).
        range_: values at the ends of the colour map.
        colour_map: Matplotlib's object.
        view: direction of the camera; it frames the union of all shapes.
        height_px: height of the pictures; the width follows from the content.
        plate: force sensor to draw.

    Returns:
        Pictures of shape (height, width, 3), and how many pixels a millimetre takes.
    """
    shapes = [skin.move(displacement) for displacement in displacements]
    fixtures = [(_clamp(skin), 1.0)] + ([(_slab(skin, plate), 0.45)] if plate else [])
    right, up, towards = view.axes
    seen = np.concatenate([*shapes, *(np.asarray(block.points) for block, _ in fixtures)])
    low, high = (f([seen @ right, seen @ up], axis=1) for f in (np.min, np.max))
    width_mm, height_mm = high - low + 2 * SIZES.margin_mm
    per_mm = height_px / height_mm

    plotter = _plotter(int(np.ceil(width_mm * per_mm)), height_px)
    try:
        surface, source = _shaded(skin)
        surface["value"] = values[0][skin.node][source]
        _add_surface(plotter, surface, colour_map, range_)
        edges, creases = _lines(skin.points, skin.edges), _lines(skin.points, skin.creases)
        plotter.add_mesh(edges, color=INK, line_width=1.0, opacity=0.22, lighting=False)
        plotter.add_mesh(creases, color=INK, line_width=2.2, opacity=0.85, lighting=False)
        for block, opacity in fixtures:
            plotter.add_mesh(block, color=PALE, opacity=opacity, ambient=0.35)
            plotter.add_mesh(block.extract_feature_edges(30), color=INK, line_width=1.5)
        middle = (low + high) / 2
        focus = middle[0] * right + middle[1] * up + np.mean(seen @ towards) * towards
        _aim(plotter, focus, view, far=3 * float(np.ptp(seen, axis=0).max()), height_mm=height_mm)

        pictures = []
        for moved, value in zip(shapes, values, strict=True):
            surface.points = moved[source]
            surface["value"] = value[skin.node][source]
            surface.point_data["Normals"] = _normals(surface)
            # Lines drawn in the surface would flicker, so they are drawn a little in front of it.
            edges.points = creases.points = moved + SIZES.lift_mm * towards
            plotter.render()
            pictures.append(np.array(plotter.screenshot(return_img=True))[..., :3])
    finally:
        plotter.close()
        plotter.deep_clean()
    return pictures, per_mm


def _plotter(width_px: int, height_px: int) -> pv.Plotter:
    """A window off screen."""
    with no_display():
        return pv.Plotter(
            off_screen=True,
            theme=scene_theme(),
            lighting="light kit",
            window_size=[width_px, height_px],
        )


def _add_surface(
    plotter: pv.Plotter, surface: Any, colour_map: Colormap, range_: tuple[float, float]
) -> None:
    """Add the skin, coloured by its array "value"."""
    plotter.add_mesh(
        surface,
        scalars="value",
        cmap=colour_map,
        clim=range_,
        smooth_shading=False,
        show_scalar_bar=False,
        ambient=0.56,
        diffuse=0.54,
        specular=0.03,
    ).prop.interpolation = "Phong"


def _aim(plotter: pv.Plotter, focus: Floats, view: View, *, far: float, height_mm: float) -> None:
    """Point a camera at ``focus`` from ``far`` (mm) away; its picture is ``height_mm`` high."""
    _, up, towards = view.axes
    plotter.camera_position = [focus + far * towards, focus, up]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = height_mm / 2
    plotter.camera.clipping_range = (0.01 * far, 2 * far)


@contextmanager
def no_display() -> Iterator[None]:
    """Make VTK open its window by EGL at once if there is no X server.

    VTK finds EGL by itself, but it first prints a warning about the missing server.
    """
    name = "VTK_DEFAULT_OPENGL_WINDOW"
    if os.environ.get("DISPLAY") or name in os.environ or not _has_egl():
        yield
        return
    os.environ[name] = "vtkEGLRenderWindow"
    try:
        yield
    finally:
        del os.environ[name]


def _has_egl() -> bool:
    """Tell whether the EGL library is installed; VTK chooses its own window without it."""
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return False
    return True


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
    surface = pv.PolyData(skin.points, faces=np.insert(skin.triangles, 0, 3, axis=1).ravel())
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


def _lines(points: Floats, segments: Ints) -> Any:
    cells = np.insert(segments, 0, 2, axis=1).ravel()
    return pv.PolyData(points.copy(), lines=cells)


def _clamp(skin: Skin) -> Any:
    """A block above the clamped face z = 0, a little larger than it."""
    z = skin.points[:, 2]
    held = skin.points[z < z.min() + 1e-6 * np.ptp(z)]
    (x0, y0, z0), (x1, y1, _) = held.min(axis=0), held.max(axis=0)
    return pv.Box((x0 - 3, x1 + 3, y0 - 3, y1 + 3, z0 - SIZES.clamp_mm, z0))


def _slab(skin: Skin, plate: Plate) -> Any:
    """A slab 3 mm thick behind the plate's face, around the point nearest to the tip."""
    normal = np.asarray(plate.normal, dtype=np.float64)
    normal /= np.linalg.norm(normal)
    low, high = skin.points.min(axis=0), skin.points.max(axis=0)
    tip = np.array([low[0], (low[1] + high[1]) / 2, high[2]])
    centre = tip - ((tip - np.asarray(plate.point_mm)) @ normal) * normal
    # The plate is tilted about y alone, so one of its edges stays parallel to y.
    across = np.array([0.0, 1.0, 0.0])
    if abs(normal[1]) > 0.9:
        across = np.array([0.0, 0.0, 1.0])
    along = np.cross(normal, across)
    along /= np.linalg.norm(along)
    across = np.cross(along, normal)
    half_width = (high[1] - low[1]) / 2 + 3
    slab = pv.Box(
        (-3.0, 0.0, -half_width, half_width, *[sign * plate.contact_length_mm for sign in (-1, 1)])
    )
    slab.points = centre + np.asarray(slab.points) @ np.array([normal, across, along])
    return slab
