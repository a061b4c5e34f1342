"""Three fingers hold a strawberry, two of them cut open.

    scripts/run dolfingrip grasp --food strawberry --set gripper.alpha_deg=30 \
        --set gripper.clearance_mm=8 --pressure 125 --preset coarse --no-video -o out/strawberry
    scripts/run python docs/pictures/strawberry_grasp.py out/strawberry

draws ``docs/strawberry_grasp.jpg``: shapes, places and stretch of the last reading. Leaves, seeds
and the palm are drawn for the eye; the simulation has the berry's flesh and the fingers alone.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from matplotlib.colors import LinearSegmentedColormap
from PIL import Image, ImageDraw
from scipy.ndimage import gaussian_filter
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from dolfingrip import config
from dolfingrip.experiments.rigs.food import grasped
from dolfingrip.files.table import read_csv
from dolfingrip.foods.strawberry import strawberry
from dolfingrip.report.gripper import moments_of
from dolfingrip.report.scene import PaintedSkin, View, segments_of
from dolfingrip.report.skin import Floats

PICTURE = Path(__file__).resolve().parents[1] / "strawberry_grasp.jpg"
VIEW = View(azimuth_deg=-37.0, elevation_deg=13.0, up=1.0)
SIZE_PX, DRAWN = (1200, 1000), 2
ICE = LinearSegmentedColormap.from_list("ice", ["#F3F6F4", "#8CC7C9", "#1F7A8C", "#0B3954"])
SEEDS, DIMPLE_MM, TABLE_MM = 170, 0.55, 82.0
SUN = np.array([420.0, -300.0, 560.0]) @ VIEW.axes[[2, 0, 1]] / 762
RED, PINK, GREEN = np.array([0.86, 0.05, 0.08]), np.array([0.96, 0.42, 0.32]), "#5FA636"


def berry(size_mm: tuple[float, float, float]) -> tuple[pv.PolyData, pv.PolyData, pv.PolyData]:
    """Flesh with dimples, seeds and calyx of a strawberry as it lies."""
    lies = strawberry()
    moments, axes = np.linalg.eigh(lies.inertia_mm5())
    lone = int(np.abs(moments - np.median(moments)).argmax())
    axis = axes[:, lone] * np.sign(axes[0, lone])  # from the calyx to the tip
    across = np.cross(axis, [0.0, 1.0, 0.0])
    frame = np.array([across, np.cross(axis, across), axis])
    scale = np.array(size_mm) / np.ptp(lies.points, axis=0)
    flesh = ClosedSkin(lies.points * scale, lies.triangles)
    points, normals = flesh.points, flesh.normals
    local = points @ frame.T
    along = (local[:, 2] - local[:, 2].min()) / np.ptp(local[:, 2])
    turn = np.arctan2(local[:, 1], local[:, 0])
    # as many seeds on each area, by the golden angle
    order = np.argsort(along)
    share = np.cumsum(flesh.areas[order]) / flesh.areas.sum()
    wanted = np.interp((np.arange(SEEDS) + 0.5) / SEEDS * 0.93 + 0.05, share, along[order])
    golden = np.pi * (3 - np.sqrt(5)) * np.arange(SEEDS)
    on = KDTree(np.column_stack([30 * along, 15 * np.cos(turn), 15 * np.sin(turn)]))
    _, at = on.query(np.column_stack([30 * wanted, 15 * np.cos(golden), 15 * np.sin(golden)]))
    away, _ = KDTree(points[at]).query(points)
    deep = np.exp(-((away / 1.15) ** 2))
    seeds = pv.merge([seed(points[i] - 0.25 * normals[i], normals[i], axis) for i in at])
    flesh.mesh.points = points - DIMPLE_MM * deep[:, None] * normals
    pale = np.clip(1 - along / 0.2, 0, 1)[:, None] ** 1.5
    shade = (1 - 0.25 * deep)[:, None]
    flesh.mesh["colour"] = np.uint8(255 * np.clip((RED * (1 - pale) + PINK * pale) * shade, 0, 1))
    return flesh.mesh.compute_normals(split_vertices=False), seeds, calyx(local, frame)


class ClosedSkin:
    """A finer surface through the same points, with its normals and areas."""

    def __init__(self, points: Floats, triangles: np.ndarray) -> None:
        coarse = pv.PolyData.from_regular_faces(points, triangles)
        self.mesh: Any = coarse.subdivide(2, "loop").compute_normals(split_vertices=False)
        self.points = np.asarray(self.mesh.points, dtype=float)
        self.normals = np.asarray(self.mesh.point_data["Normals"], dtype=float)
        faces = self.mesh.regular_faces
        third = np.repeat(self.mesh.compute_cell_sizes()["Area"] / 3, 3)
        self.areas = np.bincount(faces.ravel(), third, len(self.points))


def seed(at: Floats, normal: Floats, axis: Floats) -> pv.PolyData:
    """An ellipsoid that lies in the skin along the berry's axis."""
    along = axis - (axis @ normal) * normal
    along /= np.linalg.norm(along)
    found: Any = pv.Sphere(radius=1.0, theta_resolution=12, phi_resolution=12)
    turned = np.array([along, np.cross(normal, along), normal])
    found.points = (np.asarray(found.points) * [0.85, 0.5, 0.4]) @ turned + at
    return found


def calyx(local: Floats, frame: Floats) -> pv.PolyData:
    """Leaves over the berry's shoulder, and a stem."""
    out = np.hypot(local[:, 0], local[:, 1])
    shoulder = local[:, 2] < local[out.argmax(), 2]
    order = np.argsort(out[shoulder])
    radii, heights = out[shoulder][order], local[shoulder, 2][order]
    parts = []
    for k in range(10):
        turn, long = 2 * np.pi * k / 10 + 0.12 * (-1) ** k, 15.0 + 2.0 * ((3 * k) % 4)
        part = np.linspace(0, 1, 24)
        rim = np.sin(np.pi * np.clip(part, 0, 1) ** 0.8) * 3.6 + 0.5 * (1 - part)
        side = np.linspace(-1, 1, 9)
        radial = 0.6 + long * part
        lifted = np.interp(radial, radii, heights) - 0.5 - 6.0 * part**3  # curled off the berry
        u = np.outer(radial, np.ones(9))
        v = np.outer(rim, side)
        w = np.outer(lifted, np.ones(9)) - 0.9 * np.abs(side) * np.sin(np.pi * part)[:, None]
        x, y = u * np.cos(turn) - v * np.sin(turn), u * np.sin(turn) + v * np.cos(turn)
        sheet = pv.StructuredGrid(x, y, w).extract_surface()
        parts.append(sheet.triangulate())
    base = local[:, 2].min()
    stem = np.array(
        [[0, 0, base + 1], [0.3, 0, base - 4], [1.4, 0.4, base - 9], [3.2, 1, base - 14]]
    )
    parts.append(pv.Spline(stem, 40).tube(radius=1.1, n_sides=24).triangulate())
    found: Any = pv.merge(parts)
    found.points = np.asarray(found.points) @ frame
    return found.compute_normals(split_vertices=False, consistent_normals=False)


def draw(folder: Path) -> Image.Image:
    """The last reading of a grasp, rendered."""
    settings, result = config.load(folder / "run.json"), read_csv(folder / "result.csv", ours=True)
    body = grasped(settings.food)
    fields = folder / "fields.pvd"
    whole, moments = moments_of(fields, settings, result, body)
    opened, cut = moments_of(fields, settings, result, body, VIEW)
    last = len(moments) - 1
    turn = Rotation.from_rotvec(
        [float(result[f"object_turn_{axis}_deg"][last]) for axis in "xyz"], degrees=True
    )
    place = np.array([float(result[f"object_{axis}_mm"][last]) for axis in "xyz"])
    table = moments[last].table_mm
    range_ = (1.0, float(np.quantile(moments[last].fields["stretch"], 0.99)))

    plotter: Any = pv.Plotter(
        off_screen=True, lighting="none", window_size=[DRAWN * each for each in SIZE_PX]
    )
    plotter.set_background("#C9D6DC", top="#F4F8FA")
    # finger B stands behind the berry, whole
    for skin, moment, mine in (
        (opened, cut[last], opened.side != 1), (whole, moments[last], whole.side == 1)
    ):  # fmt: skip
        part = skin.part(mine)
        painted = PaintedSkin(plotter, part, moment.fields["stretch"][mine], ICE, range_)
        painted.show(moment.skin[mine], moment.fields["stretch"][mine])
        creases = segments_of(moment.skin[mine], part.creases)
        plotter.add_mesh(creases, color="#0B3954", line_width=1.5, opacity=0.35, lighting=False)
    flesh, seeds, leaves = berry(settings.food.size_mm)
    for mesh in (flesh, seeds, leaves):
        mesh.points = turn.apply(np.asarray(mesh.points, dtype=float)) + place
    smooth = {"smooth_shading": True, "ambient": 0.32}
    plotter.add_mesh(flesh, scalars="colour", rgb=True, specular=0.75, specular_power=38, **smooth)
    plotter.add_mesh(seeds, color="#E9C46A", specular=0.4, specular_power=20, **smooth)
    plotter.add_mesh(leaves, color=GREEN, specular=0.15, **smooth)
    top = float(moments[last].skin[:, 2].max())
    holder = [disk(47, top, 7), disk(20, top + 7, 40)]
    for (rim, face), colour in zip(holder, ("#5B6B75", "#8D99A1"), strict=True):
        plotter.add_mesh(rim, color=colour, ambient=0.3, specular=0.2, smooth_shading=True)
        plotter.add_mesh(face, color=colour, ambient=0.3)
    rim, plate = disk(TABLE_MM, table - 5, 5)
    plotter.add_mesh(rim, color="#E4DED2", ambient=0.35, smooth_shading=True)
    fingers = pv.PolyData.from_regular_faces(moments[last].skin, whole.triangles)
    shade = shadow(table, [(holder[0][1], 5.0), (fingers, 2.2), (flesh, 2.2)])
    plate.active_texture_coordinates = (np.asarray(plate.points)[:, :2] / TABLE_MM + 1) / 2
    plotter.add_mesh(plate, texture=pv.Texture(shade), ambient=0.6, diffuse=0.55)
    light(plotter, top)
    middle = np.array([0.0, 0.0, (top + 10 + table - 24) / 2])
    plotter.camera_position = [middle + 520 * VIEW.axes[2], middle, (0, 0, 1)]
    plotter.camera.view_angle = 18.6
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return Image.fromarray(image).resize(SIZE_PX, Image.Resampling.LANCZOS)


def disk(radius_mm: float, low: float, tall: float) -> tuple[pv.PolyData, pv.PolyData]:
    """A round disk: its rim, and its upper face."""
    middle, up = (0.0, 0.0, low + tall / 2), (0.0, 0.0, 1.0)
    rim = pv.Cylinder(middle, up, radius_mm, tall, resolution=240, capping=False)
    return rim, pv.Disc((0.0, 0.0, low + tall), 0.0, radius_mm, up, r_res=40, c_res=240)


def shadow(table_mm: float, bodies: list[tuple[Any, float]]) -> np.ndarray:
    """The table's face with the shadows of bodies, each softened by its standard deviation (mm)."""
    lit, per_mm = np.ones((1024, 1024)), 1024 / (2 * TABLE_MM)
    for body, soft_mm in bodies:
        surface = body.triangulate()
        points = np.asarray(surface.points, dtype=float)
        points = points - ((points[:, 2] - table_mm) / SUN[2])[:, None] * SUN
        mask = Image.new("L", lit.shape)
        corners = ((points[:, :2] + TABLE_MM) * per_mm)[surface.regular_faces]
        for triangle in corners * [1, -1] + [0, lit.shape[0]]:
            ImageDraw.Draw(mask).polygon([*triangle.ravel()], fill=255)
        part = gaussian_filter(np.asarray(mask) / 255.0, soft_mm * per_mm)
        lit = np.minimum(lit, 1 - 0.42 * part)
    return np.uint8(lit[..., None] * [250, 246, 238])


def light(plotter: Any, top: float) -> None:
    """Three lights, and darkness in corners."""
    right, up, towards = VIEW.axes
    for at, strength, colour in (
        (600 * SUN, 0.62, "#FFF4E6"), (300 * towards + 300 * right + 60 * up, 0.36, "#E8F1FF"),
        (-300 * towards + 160 * right + 260 * up, 0.25, "white"),
    ):  # fmt: skip
        plotter.add_light(pv.Light(at, (0, 0, top - 70), colour, intensity=strength))
    plotter.enable_ssao(radius=9, bias=0.4, kernel_size=128)


if __name__ == "__main__":
    draw(Path(sys.argv[1])).save(PICTURE, quality=88, optimize=True)
    print(f"wrote {PICTURE}")
