"""Shapes that the configuration's finger takes, which start the search for a silhouette."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import BSpline, LinearNDInterpolator, PchipInterpolator

from dolfingrip.config import Config
from dolfingrip.report.fields import list_steps, read_steps
from dolfingrip.report.skin import extract_skin
from dolfingrip.sections.errors import ConfigError

BEYOND: Final = 1.5
"""Largest pressure of the shapes, by the configuration's; a softer finger bends as far."""
STEPS: Final = 15
ACROSS: Final = np.linspace(-1.0, 1.0, 5)
"""Places across the finger at which it may be outermost, by half its width."""
STATION_MM: Final = 0.5
KNOT_MM: Final = 6.0

Floats = np.ndarray


@dataclass(frozen=True)
class Family:
    """Shapes of a finger by rising pressure.

    A shape is the middle line of the back, and where all other points are beside that.

    Attributes:
        stations_mm: (stations,) z of points of the middle line at rest, from clamp to tip.
        turn: (shapes, stations) rotation of the line from z towards −x (rad).
        stretch: (shapes, stations) its length by that at rest.
        points_mm: (points, 3) of the skin at rest, then of the back, then of the tip's face.
        beside_mm: (shapes, points, 3) places by the line: along it, out of the back, and y.
        triangles: (triangles, 3) of the skin.
        back, tip: numbers of their points, each (places, across the width).
    """

    stations_mm: Floats
    turn: Floats
    stretch: Floats
    points_mm: Floats
    beside_mm: Floats
    triangles: Floats
    back: Floats
    tip: Floats

    @property
    def width_mm(self) -> float:
        """Width of the finger at rest."""
        return float(np.ptp(self.points_mm[:, 1]))

    @cached_property
    def waves(self) -> Floats:
        """Splines (stations, splines) by which a finger's turn may differ from that of a shape."""
        low, high = self.stations_mm[[0, -1]]
        inner = np.linspace(low, high, max(round((high - low) / KNOT_MM), 3) + 1)
        knots = np.r_[[low] * 3, inner, [high] * 3]
        return np.asarray(BSpline.design_matrix(self.stations_mm, knots, 3).toarray())

    def between(self, values: Floats, shape: float) -> Floats:
        """Values of a shape between two others.

        Args:
            values: (shapes, …).
            shape: its number, which may be broken.
        """
        first = min(int(shape), len(values) - 2)
        return np.asarray(values[first] + (shape - first) * (values[first + 1] - values[first]))

    def line(self, turn: Floats, stretch: Floats) -> Floats:
        """Places (stations, 2), x and z (mm), of a middle line from the clamp on.

        Args:
            turn: (stations,) rad.
            stretch: (stations,).
        """
        slopes = stretch[:, None] * np.column_stack([-np.sin(turn), np.cos(turn)])
        return np.asarray(cumulative_trapezoid(slopes, self.stations_mm, axis=0, initial=0.0))

    def places(self, shape: float, off: Floats, longer: float, points: Floats) -> Floats:
        """Places (…, 3) of points where the line differs from that of a shape.

        Args:
            shape: number of the shape.
            off: (splines,) difference of the turn, by :attr:`waves`.
            longer: difference of the stretch.
            points: (…) numbers of points.
        """
        turn = self.between(self.turn, shape) + self.waves @ off
        line = self.line(turn, self.between(self.stretch, shape) * (1 + longer))
        z = self.points_mm[points, 2]
        along, out, y = np.moveaxis(self.between(self.beside_mm[:, points], shape), -1, 0)
        x0, z0, turned = (np.interp(z, self.stations_mm, values) for values in (*line.T, turn))
        cosine, sine = np.cos(turned), np.sin(turned)
        return np.stack([x0 - along * sine - out * cosine, y, z0 + along * cosine - out * sine], -1)


def simulate(config: Config, progress: Callable[[int, int], None]) -> Family:
    """Simulate free bending, and keep the shapes.

    Args:
        config: of the finger.
        progress: gets the number of shapes done, and of all.

    Raises:
        ConfigError: one line, where the finger cannot be simulated.
    """
    from dolfingrip.experiments.loop import run  # dots and tags need no solver

    most = BEYOND * config.experiment.max_pressure_kPa
    if most <= 0:
        key = f"experiment.max_pressure_kPa = {config.experiment.max_pressure_kPa:g}"
        raise ConfigError(f"{key}: allowed with --silhouette: above 0 kPa")
    experiment = config.experiment.model_copy(
        update={
            "max_pressure_kPa": most, "min_pressure_kPa": 0.0, "step_kPa": most / STEPS,
            "unload": False, "cycles": 1,
        }
    )  # fmt: skip
    rows = [0.0]

    def count(row: object) -> None:
        rows.append(1.0)
        progress(min(len(rows) - 1, STEPS + 1), STEPS + 1)

    with TemporaryDirectory() as folder:
        softer = config.model_copy(update={"experiment": experiment})
        result = run("bending", softer, out=folder, progress=count)
        if result.failure is not None and len(result.rows) < 3:
            why = result.failure.sentence()
            raise ConfigError(f"--silhouette: no shapes of the finger: {why}")
        mesh, moves, _ = read_steps(list_steps(Path(folder) / "fields.pvd"))
    skin = extract_skin(mesh)
    return of_skins(np.array([skin.move(move) for move in moves]), skin.triangles)


def of_skins(skins_mm: Floats, triangles: Floats) -> Family:
    """Make the shapes from skins.

    Args:
        skins_mm: (shapes, points, 3), the first one at resting.
        triangles: (triangles, 3).
    """
    resting = skins_mm[0]
    low, high = resting.min(axis=0), resting.max(axis=0)
    tiny = 1e-4 * (high[2] - low[2])
    on_back, on_tip = resting[:, 0] < low[0] + tiny, resting[:, 2] > high[2] - tiny
    middle = np.flatnonzero(on_back & (np.abs(resting[:, 1] - (low[1] + high[1]) / 2) < tiny))
    if len(middle) < 4:
        raise ConfigError("--silhouette: the back has no middle line; allowed: a flat back")
    middle = middle[np.argsort(resting[middle, 2])]
    stations = np.linspace(low[2], high[2], round((high[2] - low[2]) / STATION_MM) + 1)
    line = PchipInterpolator(resting[middle, 2], skins_mm[:, middle][..., [0, 2]], axis=1)(stations)
    slopes = np.gradient(line, stations, axis=1)
    turn = np.unwrap(np.arctan2(-slopes[..., 0], slopes[..., 1]), axis=1)
    y = 0.998 * ACROSS * (high[1] - low[1]) / 2 + (high[1] + low[1]) / 2
    grids = []
    for there, axis, places in (
        (on_back, 2, np.arange(low[2] + 1.0, high[2] - 0.7, STATION_MM)),
        (on_tip, 0, np.linspace(low[0] + 1.0, low[0] + 0.8 * (high[0] - low[0]), 12)),
    ):
        at = np.stack(np.meshgrid(y, places), axis=-1).reshape(-1, 2)
        moved = np.moveaxis(skins_mm[:, there], 0, 1)
        grids.append(
            np.moveaxis(LinearNDInterpolator(resting[there][:, [1, axis]], moved)(at), 1, 0)
        )
    points = np.concatenate([skins_mm, *grids], axis=1)
    beside = np.empty_like(points)
    for k in range(len(points)):
        columns = (*line[k].T, turn[k])
        x0, z0, turned = (np.interp(points[0, :, 2], stations, values) for values in columns)
        x, z = points[k, :, 0] - x0, points[k, :, 2] - z0
        beside[k, :, 0] = z * np.cos(turned) - x * np.sin(turned)
        beside[k, :, 1] = -x * np.cos(turned) - z * np.sin(turned)
        beside[k, :, 2] = points[k, :, 1]
    numbers = np.arange(skins_mm.shape[1], points.shape[1]).reshape(-1, len(ACROSS))
    rows = grids[0].shape[1] // len(ACROSS)
    return Family(
        stations, turn, np.linalg.norm(slopes, axis=2), points[0], beside, triangles,
        numbers[:rows], numbers[rows:],
    )  # fmt: skip
