"""A hexagonal finger of three equal chambers, as a mesh of threefold symmetry."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.meshes import files
from dolfingrip.meshes.cells import HEXAHEDRON
from dolfingrip.meshes.solid import SolidMesh, assemble, boundary, faces

CHAMBERS = ("cavity", "cavity_2", "cavity_3")


def hexagon(side_mm: float = 8.0, length_mm: float = 24.0, cells: int = 3) -> SolidMesh:
    """A hexagonal finger of three rhombi, each with a chamber, of threefold symmetry about z."""
    layers = 4
    n = cells + 1
    level = np.linspace(0.0, length_mm, layers + 1)
    points, solid, chamber = [], [], []
    for k in range(3):
        ways = [np.radians(120.0 * (k + i)) for i in (0, 1)]
        first, second = (np.array([np.cos(a), np.sin(a)]) * side_mm / cells for a in ways)
        start = len(points) * n * n * (layers + 1)
        i, j, z = np.meshgrid(range(n), range(n), range(layers + 1), indexing="ij")
        plane = i[..., None] * first + j[..., None] * second
        points.append(np.column_stack([plane.reshape(-1, 2), level[z].ravel()]))
        index = start + np.arange(n * n * (layers + 1)).reshape(n, n, layers + 1)
        at = np.argwhere(np.ones((cells, cells, layers), dtype=bool))
        hollow = (at[:, :2] == 1).all(axis=1) & (at[:, 2] > 0) & (at[:, 2] < layers - 1)
        corners = HEXAHEDRON.reference.astype(int)
        solid.append(np.column_stack([index[tuple((at[~hollow] + c).T)] for c in corners]))
        middle = (first + second) * 1.5
        chamber.append(middle)
    every = np.concatenate(points)
    _, kept, number = np.unique(np.round(every, 6), axis=0, return_index=True, return_inverse=True)
    nodes, elements = every[kept], number.ravel()[np.concatenate(solid)]
    outer = faces(elements)[boundary(elements)]
    centre = nodes[outer].mean(axis=1)
    groups = {"clamp": centre[:, 2] < 1e-9, "tip": centre[:, 2] > length_mm - 1e-9}
    for name, middle in zip(CHAMBERS, chamber, strict=True):
        near = np.linalg.norm(centre[:, :2] - middle, axis=1) < 0.9 * side_mm / cells
        groups[name] = near & ~groups["clamp"] & ~groups["tip"]
    groups["skin"] = ~np.any(list(groups.values()), axis=0)
    return assemble(nodes, elements, {name: outer[where] for name, where in groups.items()})


def driven(folder: Path, pressure_kPa: Sequence[float], **own_kPa: Sequence[float]) -> Config:
    """The finger in a folder's mesh file, with pressures a second apart, and supplies of cavities.

    Args:
        folder: of the mesh file.
        pressure_kPa: of the cavities without a supply of their own.
        own_kPa: pressures of each supply by the name of its cavity.
    """
    file = folder / "hexagon.msh"
    if not file.exists():
        files.write(file, hexagon())
    cavities = {name: {"pressure_kPa": [*own]} for name, own in own_kPa.items()}
    return configuration.from_dict(
        {
            "finger": {"kind": "adopted"},
            "mesh": {"file": str(file)},
            "material": {"mu_MPa": 0.1},
            "contact": {"self_contact": False},
            "cavity": cavities,
            "protocol": {
                "time_s": [float(i) for i in range(len(pressure_kPa))],
                "pressure_kPa": [*pressure_kPa],
            },
        }
    )
