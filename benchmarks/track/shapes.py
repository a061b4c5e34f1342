"""Shapes of small fingers over pressure, simulated once and interpolated between."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.interpolate import PchipInterpolator

from dolfingrip.config import Config, load
from dolfingrip.experiments.loop import run
from dolfingrip.report.fields import list_steps, load_result, read_steps
from dolfingrip.report.skin import extract_skin

SMALL: Final[dict[str, Any]] = {
    "finger.length_mm": 62,
    "finger.bellows": 4,
    "mesh.size_mm": 6,
    "mesh.edge_size_mm": 6,
    "experiment.step_kPa": 15,
}
FINGERS: Final[dict[str, dict[str, Any]]] = {
    "plain": {"experiment.max_pressure_kPa": 150},
    "soft": {"experiment.max_pressure_kPa": 105, "material.mu_MPa": 2.2},
    "uneven": {
        "experiment.max_pressure_kPa": 150,
        "mesh.size_mm": 5,
        "mesh.edge_size_mm": 5,
        "extensions.uneven_stiffness.a_1": 0.4,
    },
}
"""Changes of the configuration by the finger's name."""

BACK_MM: Final = {"dots": 2.0, "tags": 3.0}
"""Distance of points from the back's edge, by their kind."""


@dataclass(frozen=True)
class Shapes:
    """A finger's skin over pressure.

    Attributes:
        pressures_kPa: (n,) of the simulated states.
        points_mm: (n, points, 3) places of the skin.
        triangles: (m, 3).
    """

    pressures_kPa: np.ndarray
    points_mm: np.ndarray
    triangles: np.ndarray

    def at(self, pressures_kPa: np.ndarray) -> np.ndarray:
        """Places of the skin (k, points, 3) at some pressures (k,)."""
        return np.asarray(
            PchipInterpolator(self.pressures_kPa, self.points_mm, axis=0)(pressures_kPa)
        )

    def on_back(self, z_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points on the middle of the back, as :meth:`on_side` has them.

        Args:
            z_mm: (k,) distances from the clamp at rest.
        """
        rest = self.points_mm[0]
        nodes = np.flatnonzero((rest[:, 0] < 1e-6) & (np.abs(rest[:, 1]) < 1e-6))
        nodes = nodes[np.argsort(rest[nodes, 2])]
        z = rest[nodes, 2]
        cell = np.clip(np.searchsorted(z, z_mm, "right") - 1, 0, len(z) - 2)
        share = (z_mm - z[cell]) / (z[cell + 1] - z[cell])
        corners = np.stack([nodes[cell], nodes[cell + 1], nodes[cell + 1]], axis=1)
        return corners, np.stack([1 - share, share, 0 * share], axis=1)

    def on_side(self, z_mm: np.ndarray, x_mm: float) -> tuple[np.ndarray, np.ndarray]:
        """Points of the skin on the side near the back: triangles' corners and their weights.

        Args:
            z_mm: (k,) distances from the clamp at rest.
            x_mm: distance from the back at rest.

        Returns:
            Numbers of three points each, (k, 3), and barycentric weights, (k, 3).
        """
        rest = self.points_mm[0]
        side = rest[:, 1].min()
        on = (np.abs(rest[self.triangles][:, :, 1] - side) < 1e-6).all(axis=1)
        found, weights = [], []
        for z in z_mm:
            best: tuple[float, Any, Any] = (-np.inf, None, None)
            for corners in self.triangles[on]:
                a, b, c = rest[corners][:, [0, 2]]
                matrix = np.array([b - a, c - a]).T
                if abs(np.linalg.det(matrix)) < 1e-9:
                    continue
                share = np.linalg.solve(matrix, np.array([x_mm, z]) - a)
                each = np.array([1 - share.sum(), *share])
                best = max(best, (float(each.min()), corners, each), key=lambda item: item[0])
            found.append(best[1])
            weights.append(best[2])
        return np.array(found), np.array(weights)


def shapes(name: str, out: Path, config: Config | None = None) -> Shapes:
    """The shapes of a finger, from a file that is made where it is missing.

    Args:
        name: of the file.
        out: folder of the runs.
        config: of the finger; None: that of a name in :data:`FINGERS`.
    """
    file = out / f"{name}.npz"
    if not file.exists():
        folder = out / name
        run("bending", config or load(overrides={**SMALL, **FINGERS[name]}), out=folder)
        table = load_result(folder / "fields.pvd", None)
        mesh, moves, _ = read_steps(list_steps(folder / "fields.pvd"))
        skin = extract_skin(mesh)
        pressures = np.array(table["pressure_kPa"], dtype=float)
        rising = np.concatenate([[True], np.diff(pressures) > 0])
        np.savez(
            file,
            pressures=pressures[rising],
            points=np.array([skin.move(each) for each in moves])[rising],
            triangles=skin.triangles,
        )
    stored = np.load(file)
    return Shapes(stored["pressures"], stored["points"], stored["triangles"])
