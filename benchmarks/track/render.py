"""Videos as phones make them of the package's own fingers, with all that is in them known."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import av
import cv2
import numpy as np
import pyvista as pv

from benchmarks.track.shapes import BACK_MM, Shapes
from dolfingrip.files import whole
from dolfingrip.tracking.sheet import SHEETS

MARGIN_PX: Final = 24
"""Of the part of a frame that is rendered, around all shapes of the finger."""


@dataclass(frozen=True)
class Scene:
    """Finger, camera, light and log of a video.

    Attributes:
        finger: name of the shapes.
        size_px: width and height.
        rate_hz: frames per second.
        seconds: length of the video.
        tilt_deg, tilt_way_deg: angle of the camera against the plane, and the way it is turned.
        distance_mm: camera to sheet.
        focal: focal length by the longer side.
        k1, k2: distortion.
        centre: principal point from the picture's middle, by the longer side.
        turned_deg: the finger's plane against the sheet, about its length and across.
        in_front_mm: dots in front of the sheet; the finger's middle where there are none.
        sheet: whether there is one.
        marks: ``dots``, ``tags`` or ``none``.
        count: number of them.
        colour: of the dots, in blue, green and red.
        radius_mm: of the dots.
        blur: part of the time between frames in which a frame is exposed; 0: none.
        noise: of a pixel, of 255.
        uneven: how much darker one side is lit.
        cast: (3,) factors of a coloured light.
        cable: whether one hangs in front.
        decoys: number of other things of the dots' colour.
        fingers: 1 or 2.
        bits_per_px: that H.264 spends on a pixel: phones 17 Mbit/s of 1080p, 8 to 12 of 720p.
        shift_s: time of the log at the first frame.
        lag_s: the finger follows the pressure by this much later.
        light: whether a light shows in both.
        event: part of the time between frames at which it goes on.
        seed: of noise and places.
        stops: of the rising pressure, which is held at each; 0: a ramp up and down.
        gauge_kPa: noise of the logged pressure.
    """

    finger: str = "plain"
    size_px: tuple[int, int] = (1280, 720)
    rate_hz: float = 30.0
    seconds: float = 5.0
    tilt_deg: float = 0.0
    tilt_way_deg: float = 0.0
    distance_mm: float = 520.0
    focal: float = 0.9
    k1: float = 0.0
    k2: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)
    turned_deg: tuple[float, float] = (0.0, 0.0)
    in_front_mm: float = 12.0
    sheet: bool = True
    marks: str = "dots"
    count: int = 6
    colour: tuple[int, int, int] = (40, 40, 220)
    radius_mm: float = 1.5
    blur: float = 0.0
    noise: float = 2.0
    uneven: float = 0.1
    cast: tuple[float, float, float] = (1.0, 1.0, 1.0)
    cable: bool = False
    decoys: int = 0
    fingers: int = 1
    bits_per_px: float = 0.3
    shift_s: float = 2.0
    lag_s: float = 0.0
    light: bool = True
    event: float = 0.37
    seed: int = 0
    stops: int = 0
    gauge_kPa: float = 0.2
    extra: dict[str, Any] = field(default_factory=dict)


NOTHING: Final = (201, 1, 77)
"""Colour of what is rendered where there is nothing, which no thing has."""

LIGHT_MM: Final = (-40.0, 12.0)
LENGTH_MM: Final = 60.0
"""Length of the scale where there is no sheet."""
AHEAD_MM: Final = 1.2
"""Points before the finger's side: the heads of pins."""


def pressure_kPa(time_s: np.ndarray, most_kPa: float, scene: Scene) -> np.ndarray:
    """A rest, a ramp up, a wait, a ramp down, a rest, or stops: in times of the video.

    Args:
        time_s: since the first frame.
        most_kPa: the largest pressure.
        scene: whose video it is.
    """
    at, levels = np.array([0.0, 0.1, 0.55, 0.65, 0.95, 1.0]), np.array([0, 0, 1, 1, 0, 0])
    if scene.stops:
        at = np.arange(2 * scene.stops + 2) / 2 + np.tile([0.0, 0.25], scene.stops + 1)
        at, levels = at / at[-1], np.repeat(np.linspace(0, 1, scene.stops + 1), 2)
    return np.interp(time_s, scene.seconds * at, most_kPa * levels)


class Stage:
    """Renders frames of a scene; the camera looks along +y."""

    def __init__(self, scene: Scene, shapes: Shapes) -> None:
        self.scene, self.shapes = scene, shapes
        self.random = np.random.default_rng(scene.seed)
        rest = shapes.points_mm[0]
        self.side_mm = float(rest[:, 1].min())
        self.length_mm = float(rest[:, 2].max())
        self.sheet_y = scene.in_front_mm
        if scene.marks != "none":
            self.sheet_y += self.side_mm - AHEAD_MM
        self._camera()
        self._marks()
        self._background()
        self._plotter()

    def _camera(self) -> None:
        s = self.scene
        width, height = s.size_px
        f = s.focal * max(width, height)
        u, v = (np.array([width, height]) - 1) / 2 + np.array(s.centre) * max(width, height)
        self.matrix = np.array([[f, 0, u], [0, f, v], [0, 0, 1.0]])
        self.lens = np.array([s.k1, s.k2, 0.0, 0.0])
        along, across = np.radians(s.turned_deg)
        self.turned = cv2.Rodrigues(np.array([across, 0.0, along]))[0]
        self.pivot = np.array([0.0, self.sheet_y - s.in_front_mm, 0.0])
        # world of the sheet: u = −x (to the right), v = z (down), w = y (into the paper)
        tilt, way = np.radians([s.tilt_deg, s.tilt_way_deg])
        axis = tilt * np.array([np.cos(way), np.sin(way), 0.0])
        self.rotation = cv2.Rodrigues(axis)[0]
        self.target = np.array(s.extra.get("target", (12.0, 42.0, 0.0)))
        self.place = np.array([0, 0, s.distance_mm]) - self.rotation @ self.target

    def project(self, world_mm: np.ndarray) -> np.ndarray:
        """Pixels (…, 2) of points (…, 3) in x, y, z of the model."""
        flat = self.to_sheet(world_mm).reshape(-1, 3)
        found, _ = cv2.projectPoints(
            flat, cv2.Rodrigues(self.rotation)[0], self.place, self.matrix, self.lens
        )
        return np.asarray(found.reshape(*world_mm.shape[:-1], 2))

    def to_sheet(self, world_mm: np.ndarray) -> np.ndarray:
        x, y, z = np.moveaxis((world_mm - self.pivot) @ self.turned.T + self.pivot, -1, 0)
        return np.stack([-x, z, y - self.sheet_y], axis=-1)

    def _marks(self) -> None:
        s = self.scene
        if s.marks == "none":  # truth on the middle of the back, whose points no one sees
            self.z_mm = self.length_mm * np.arange(1, s.count + 1) / s.count
            self.corners, self.weights = self.shapes.on_back(self.z_mm)
            self.ahead = self.shapes.on_back(self.z_mm)
            self.behind = self.shapes.on_back(self.z_mm - 1.5)
            return
        low, x = 4.0, BACK_MM[s.marks]
        self.z_mm = np.linspace(low, self.length_mm - 2.0, s.count)
        self.corners, self.weights = self.shapes.on_side(self.z_mm, x)
        ahead = self.shapes.on_side(np.minimum(self.z_mm + 1.5, self.length_mm - 0.01), x)
        behind = self.shapes.on_side(self.z_mm - 1.5, x)
        self.ahead, self.behind = ahead, behind

    def marks(self, skin_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places (k, n, 3) of the marks on skins (k, points, 3), and turns (k, n) from z (rad)."""

        def places(corners: np.ndarray, weights: np.ndarray) -> np.ndarray:
            return np.einsum("knpc,np->knc", skin_mm[:, corners], weights)

        found = places(self.corners, self.weights)
        arm = places(*self.ahead) - places(*self.behind)
        if self.scene.marks != "none":
            found[..., 1] = np.minimum(found[..., 1], self.side_mm) - AHEAD_MM  # the side swells
        return found, np.arctan2(-arm[..., 0], arm[..., 2])

    def copies(self) -> list[np.ndarray]:
        """Shifts (x) of the fingers; the second one is a mirror image."""
        return (
            [np.zeros(3)]
            if self.scene.fingers == 1
            else [np.array([-6.0, 0, 0]), np.array([34.0, 0, 0])]
        )

    def _background(self) -> None:
        s = self.scene
        width, height = s.size_px
        rng = self.random
        px_per_mm = 6
        # a plane of 600 × 600 mm around the clamp's mark
        half = 300
        board = np.full((2 * half * px_per_mm, 2 * half * px_per_mm, 3), 205, np.uint8)
        if s.sheet:
            sheet = SHEETS["a4"]
            w, h = sheet.size_mm
            left, top = sheet.corner_mm
            across, down = (n * sheet.square_mm for n in sheet.squares)
            x0, y0 = left + across / 2 - w / 2, top + down / 2 - h / 2
            p0 = ((np.array([x0, y0]) + half) * px_per_mm).astype(int)
            p1 = ((np.array([x0 + w, y0 + h]) + half) * px_per_mm).astype(int)
            board[p0[1] : p1[1], p0[0] : p1[0]] = 240
            cell = sheet.square_mm / 8 * px_per_mm
            size = (round(sheet.bits.shape[1] * cell), round(sheet.bits.shape[0] * cell))
            bits = cv2.resize(
                np.where(sheet.bits, 25, 240).astype(np.uint8),
                size,
                interpolation=cv2.INTER_NEAREST,
            )
            c0 = np.round((np.array([left, top]) + half) * px_per_mm).astype(int)
            board[c0[1] : c0[1] + size[1], c0[0] : c0[0] + size[0]] = bits[..., None]
        # the board's pixel (i, j) has its centre at (j + 0.5)/px_per_mm − half
        ruler = (np.array([70, 30]) + half) * px_per_mm
        cv2.rectangle(
            board, ruler.tolist(), (ruler + np.array([60, 500])).tolist(), (120, 190, 210), -1
        )
        for i in range(25):
            y = ruler[1] + 20 * i
            cv2.line(
                board,
                (int(ruler[0]), int(y)),
                (int(ruler[0] + (30 if i % 5 else 50)), int(y)),
                (20, 20, 20),
                2,
            )
        for _ in range(s.decoys):
            at = (rng.uniform([-45, 70], [-20, 130]) + half) * px_per_mm
            kind = rng.integers(3)
            size = rng.uniform(3, 9) * px_per_mm
            if kind == 0:
                cv2.circle(board, at.astype(int).tolist(), int(size), s.colour, -1)
            elif kind == 1:
                cv2.rectangle(
                    board,
                    at.astype(int).tolist(),
                    (at + size * np.array([3, 0.6])).astype(int).tolist(),
                    s.colour,
                    -1,
                )
            else:
                cv2.putText(
                    board,
                    "R5",
                    at.astype(int).tolist(),
                    cv2.FONT_HERSHEY_DUPLEX,
                    size / 12,
                    s.colour,
                    5,
                )
        # sheet mm → undistorted pixel → distorted picture
        to_board = np.array(
            [
                [px_per_mm, 0, half * px_per_mm - 0.5],
                [0, px_per_mm, half * px_per_mm - 0.5],
                [0, 0, 1],
            ]
        )
        homography = self.matrix @ np.column_stack(
            [self.rotation[:, 0], self.rotation[:, 1], self.place]
        )
        over = 2
        grid = np.stack(
            np.meshgrid(*((np.arange(n * over) + 0.5) / over - 0.5 for n in (width, height))),
            axis=-1,
        )
        rays = cv2.undistortPoints(
            grid.reshape(-1, 1, 2).astype(np.float64), self.matrix, self.lens, P=self.matrix
        )
        rays = rays.reshape(-1, 2)
        whole = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).reshape(
            -1, 1, 2
        )
        pixels = cv2.undistortPoints(
            whole.astype(np.float64), self.matrix, self.lens, P=self.matrix
        )
        self.rays = pixels.reshape(height, width, 2).astype(np.float32)
        mm = np.column_stack([rays, np.ones(len(rays))]) @ np.linalg.inv(homography).T
        at = (mm / mm[:, 2:]) @ to_board.T
        maps = at[:, :2].reshape(height * over, width * over, 2).astype(np.float32)
        fine = cv2.remap(
            board, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderValue=(150, 160, 165)
        )
        self.background = cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA).astype(
            np.float32
        )
        u, v = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
        way = rng.uniform(0, 2 * np.pi)
        self.lighting = (1 - s.uneven * (0.5 + 0.5 * (u * np.cos(way) + v * np.sin(way))))[
            ..., None
        ].astype(np.float32)
        self.lit = self.lighting * np.array(s.cast, dtype=np.float32)
        self.grains = [
            rng.normal(0, s.noise, self.background.shape).astype(np.float32) for _ in range(3)
        ]
        self.light_px = self.project(np.array([[-LIGHT_MM[0], self.sheet_y, LIGHT_MM[1]]]))[0]

    def _plotter(self) -> None:
        s = self.scene
        self.over = 2
        self._window()
        width, height = (self.over * int(n) for n in self.high - self.low)
        p = pv.Plotter(off_screen=True, window_size=[width, height], lighting="none")
        self.plotter = p
        p.set_background([each / 255 for each in NOTHING[::-1]])
        self.skins, self.discs = [], []
        faces = np.column_stack(
            [np.full(len(self.shapes.triangles), 3), self.shapes.triangles]
        ).ravel()
        for _ in self.copies():
            skin = pv.PolyData(self.shapes.points_mm[0].copy(), faces)
            p.add_mesh(
                skin,
                color=s.extra.get("body", "#8f9aa5"),
                smooth_shading=False,
                ambient=0.35,
                diffuse=0.6,
                specular=0.2,
            )
            self.skins.append(skin)
        clamp = pv.Box((-6, 24, self.side_mm - 4, self.sheet_y, -16, 0))
        p.add_mesh(clamp, color="#30343a", ambient=0.5)
        p.add_light(pv.Light(position=(60, -400, -150), focal_point=(0, 0, 40), intensity=1.0))
        self.p_marks = []
        if s.marks == "tags":
            dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
        for _ in self.copies():
            for i in range(s.count if s.marks != "none" else 0):
                if s.marks == "dots":
                    disc = pv.Disc(inner=0, outer=s.radius_mm, normal=(0, -1, 0), r_res=1, c_res=40)
                    disc = disc.triangulate()
                    disc.points[:, 1] = 0
                    colour = np.array(s.colour[::-1]) / 255
                    p.add_mesh(disc, color=colour, lighting=False)
                else:
                    half = s.extra.get("tag_mm", 7.0) / 2 * 8 / 6
                    disc = pv.Plane(
                        center=(0, 0, 0),
                        direction=(0, -1, 0),
                        i_size=1,
                        j_size=1,
                        i_resolution=1,
                        j_resolution=1,
                    )
                    disc.points = np.array(
                        [[half, 0, half], [-half, 0, half], [half, 0, -half], [-half, 0, -half]]
                    )
                    disc.active_texture_coordinates = np.array(
                        [[0, 0], [1, 0], [0, 1], [1, 1]], dtype=np.float32
                    )
                    picture = np.full((400, 400), 250, np.uint8)
                    picture[50:350, 50:350] = np.where(
                        cv2.aruco.generateImageMarker(dictionary, i, 300) > 0, 250, 20
                    )
                    texture = pv.Texture(np.repeat(picture[..., None], 3, axis=2))
                    texture.mipmap = True
                    texture.interpolate = True
                    p.add_mesh(disc, texture=texture, lighting=False)
                self.p_marks.append((disc, np.array(disc.points)))
        position = -self.rotation.T @ self.place  # in the sheet's coordinates
        swap = np.array([[-1.0, 0, 0], [0, 0, 1], [0, 1, 0]])
        world = swap @ position + np.array([0, self.sheet_y, 0]) - self.pivot
        world = self.turned.T @ world + self.pivot
        ahead, up = (self.turned.T @ swap @ self.rotation[i] for i in (2, 1))
        p.camera.position = world
        p.camera.focal_point = world + ahead * s.distance_mm
        p.camera.up = -up
        size = self.high - self.low
        p.camera.view_angle = 2 * np.degrees(np.arctan(size[1] / 2 / self.matrix[0, 0]))
        off = ((self.low + self.high - 1) / 2 - self.matrix[:2, 2]) / (size / 2)
        p.camera.SetWindowCenter(off[0], -off[1])
        p.camera.clipping_range = (50, 2000)
        rays = self.rays[self.part]
        self.maps = ((rays - self.low + 0.5) * self.over - 0.5).astype(np.float32)

    def _window(self) -> None:
        """The part of a frame in which the finger ever is, without and with distortion."""
        skins = self.shapes.points_mm
        around = [np.array(each) for each in ((-8, self.side_mm, -18), (26, self.side_mm, -18))]
        world = np.concatenate([skins.reshape(-1, 3), around])
        every = np.concatenate(
            [world * np.array([1 - 2 * c, 1, 1]) + each for c, each in enumerate(self.copies())]
        )
        camera = self.to_sheet(every) @ self.rotation.T + self.place
        flat = camera @ self.matrix.T
        flat = flat[:, :2] / flat[:, 2:]
        limits = np.array(self.scene.size_px)
        self.low = np.floor(np.clip(flat.min(axis=0) - MARGIN_PX, 0, limits - 8)).astype(int)
        self.high = np.ceil(np.clip(flat.max(axis=0) + MARGIN_PX, 8, limits)).astype(int)
        inside = ((self.rays >= self.low) & (self.rays <= self.high - 1)).all(axis=2)
        rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
        self.part = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))

    def foreground(self, skin_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Finger, clamp and marks, and how much of each pixel they cover."""
        marks, turns = self.marks(skin_mm[None])
        n = self.scene.count if self.scene.marks != "none" else 0
        for c, shift in enumerate(self.copies()):
            mirror = np.array([1 - 2 * c, 1, 1])
            self.skins[c].points = skin_mm * mirror + shift
            for i in range(n):
                disc, rest = self.p_marks[c * n + i]
                turn = turns[0, i] * (1 - 2 * c)
                # rotation towards −x of z
                x = rest[:, 0] * np.cos(turn) - rest[:, 2] * np.sin(turn)
                z = rest[:, 0] * np.sin(turn) + rest[:, 2] * np.cos(turn)
                disc.points = (
                    np.column_stack([x, np.zeros(len(x)), z]) + marks[0, i] * mirror + shift
                )
        self.plotter.render()
        shot = np.asarray(self.plotter.screenshot(return_img=True))[..., 2::-1]
        cover = (shot != NOTHING).any(axis=2).astype(np.float32)
        image = shot.astype(np.float32)
        both = np.dstack([image * cover[..., None], cover])
        both = cv2.blur(both, (2, 2), anchor=(0, 0)) if self.over == 2 else both
        # the blur's picture has its pixel centres half a pixel further
        found = cv2.remap(both, self.maps[..., 0] - 0.5, self.maps[..., 1] - 0.5, cv2.INTER_LINEAR)
        return found[..., :3], found[..., 3:]

    def frame(self, skins_mm: np.ndarray, lit: float) -> np.ndarray:
        """One frame, exposed while the finger has some shapes (k, points, 3)."""
        s = self.scene
        picture = self.background.copy()
        behind = self.background[self.part]
        total = np.zeros_like(behind)
        for skin in skins_mm:
            image, cover = self.foreground(skin)
            total += image + behind * (1 - cover)
        picture[self.part] = total / len(skins_mm)
        if s.cable:
            points = self.cable_px()
            layer = np.zeros(picture.shape[:2], np.uint8)
            scale = self.scene.size_px[1] / 720
            cv2.polylines(
                layer,
                [np.round(points * 8).astype(int)],
                False,
                255,
                int(5 * scale),
                cv2.LINE_AA,
                3,
            )
            share = layer[..., None].astype(np.float32) / 255
            picture = picture * (1 - share) + np.array([35, 35, 35]) * share
        if s.light:
            at = np.round(self.light_px).astype(int)
            colour = (60 + 190 * lit) * np.array([0.9, 1.0, 0.9])
            cv2.circle(
                picture, at.tolist(), max(4, s.size_px[1] // 120), colour.tolist(), -1, cv2.LINE_AA
            )
        picture *= self.lit
        grain = self.grains[int(self.random.integers(len(self.grains)))]
        picture += np.roll(grain, self.random.integers(0, 200, 2), axis=(0, 1))
        return np.clip(np.round(picture), 0, 255).astype(np.uint8)

    def cable_px(self) -> np.ndarray:
        z = np.linspace(-20, 110, 60)
        x = -30 + 8 * np.sin(z / 25)
        return self.project(np.column_stack([x, np.full(60, self.side_mm - 30), z]))


@contextmanager
def _encoded(file: Path, scene: Scene) -> Iterator[Callable[[np.ndarray], None]]:
    """Write a video as a phone does: at a bit rate, with colour at every second pixel.

    A colour's place is that of H.264 where nothing else is told: on the left one of two pixels,
    between two lines (ITU-T H.264, annex E, chroma_loc_info).
    """
    rate = scene.bits_per_px * scene.rate_hz * scene.size_px[0] * scene.size_px[1]
    with whole.replacing(file) as (partial,), av.open(str(partial), "w", format="mp4") as container:
        stream = container.add_stream(
            "libx264", rate=Fraction(scene.rate_hz).limit_denominator(1000),
            options={"b": str(round(rate)), "preset": "fast"},
        )  # fmt: skip
        stream.width, stream.height = scene.size_px
        stream.pix_fmt = "yuv420p"

        def add(image: np.ndarray) -> None:
            full = av.VideoFrame.from_ndarray(image, format="bgr24").reformat(format="yuv444p")
            y, *colours = full.to_ndarray()
            left = [cv2.sepFilter2D(each, -1, np.array([0.25, 0.5, 0.25]), np.array([0.5, 0.5]),
                                    anchor=(1, 0))[::2, ::2] for each in colours]  # fmt: skip
            planes = np.concatenate([y.ravel(), *(each.ravel() for each in left)])
            half = planes.reshape(-1, image.shape[1])
            container.mux(stream.encode(av.VideoFrame.from_ndarray(half, format="yuv420p")))

        yield add
        container.mux(stream.encode())


def render(scene: Scene, shapes: Shapes, stem: Path) -> dict[str, np.ndarray]:
    """Write a video, its log and its truth.

    Returns:
        ``time_s`` (frames,), ``marks_mm`` (fingers, frames, n, 2) x and z, ``turns`` (fingers,
        frames, n) in rad, ``pressure_kPa`` (frames,), ``marks_px``.
    """
    stage = Stage(scene, shapes)
    most = float(shapes.pressures_kPa[-1])
    count = round(scene.seconds * scene.rate_hz)
    time_s = np.arange(count) / scene.rate_hz
    exposures = (
        np.linspace(-0.25, 0.25, 2) * scene.blur / scene.rate_hz if scene.blur else np.zeros(1)
    )
    event_s = 0.06 * scene.seconds + scene.event / scene.rate_hz
    stem.parent.mkdir(parents=True, exist_ok=True)
    with _encoded(stem.with_suffix(".mp4"), scene) as add:
        for t in time_s:
            p = pressure_kPa(t + exposures - scene.lag_s, most, scene)
            add(stage.frame(shapes.at(p), float(t >= event_s)))
    stage.plotter.close()
    skins = shapes.at(pressure_kPa(time_s - scene.lag_s, most, scene))
    marks, turns = stage.marks(skins)
    places, angles, seen = [], [], []
    for c, shift in enumerate(stage.copies()):
        world = marks * np.array([1 - 2 * c, 1, 1]) + shift
        places.append(world[..., [0, 2]])
        angles.append(turns * (1 - 2 * c))
        seen.append(stage.project(world))
    log_s = np.arange(-1.0, scene.seconds + 1.0, 0.01)
    own = np.random.default_rng(scene.seed + 1)
    logged = pressure_kPa(log_s, most, scene) + own.normal(0, scene.gauge_kPa, len(log_s))
    lines = ["time_s,pressure_kPa,light"]
    first = log_s[0] + scene.shift_s
    lines += [
        f"{t + scene.shift_s:.3f},{p:.3f},{int(t >= event_s)}"
        for t, p in zip(log_s, logged, strict=True)
    ]
    stem.with_suffix(".log.csv").write_text("\n".join(lines) + "\n")
    truth = {
        "time_s": time_s, "marks_mm": np.array(places),
        "turns": np.array(angles), "marks_px": np.array(seen),
        "pressure_kPa": pressure_kPa(time_s, most, scene), "light_px": stage.light_px,
        "first_s": np.array(first),
        "scale_px": stage.project(
            np.array([[10.0, stage.sheet_y, 5.0], [10.0, stage.sheet_y, 5.0 + LENGTH_MM]])
        ),
        "z_mm": stage.z_mm,
        "clamp_px": stage.project(
            np.array([[0.0, 0.0 if scene.marks == "none" else stage.side_mm - 0.4, 0.0]])
        )[0],
    }  # fmt: skip
    np.savez(stem.with_suffix(".npz"), **truth)
    return truth
