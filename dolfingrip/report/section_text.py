"""A finger's section as text, small enough for a terminal."""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.solid import Floats, Ints, SolidMesh

BLOCKS = " ▄▀█"
"""Characters by whether their lower and their upper half are solid."""


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
    return "\n".join("".join(BLOCKS[each] for each in row) for row in pairs[::-1])
