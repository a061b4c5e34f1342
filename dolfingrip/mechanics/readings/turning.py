"""The rotation of a body along z from its clamped end to its tip, also beyond half a turn."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from dolfingrip.mechanics.model.model import Model

SLICES = 24
"""Number of slices along the length. If a finger curls by two turns, neighbours differ by 30°."""

FLAT = 1e-9
"""Smallest moment of inertia of a slice, divided by its number of nodes and the length squared."""


class Turning:
    """Rotation about y of the slices of a body (deg), towards −x.

    The rotation of a slice is the rotation nearest to the motion of its displacement nodes
    by least squares: θ = atan2(Σ (x z' − z x'), Σ (x x' + z z')), with coordinates from their
    means. Whole turns are missing in it. From slice to slice it changes by less than half a turn,
    so the present state tells the turns of all slices but the first. The first slice, at the clamp,
    keeps the turn in which it was last.

    Args:
        model: model that is read; its clamped end has the smallest z.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        space = model.u.function_space
        nodes = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local]
        low = model.comm.allreduce(float(nodes[:, 2].min(initial=np.inf)), MPI.MIN)
        high = model.comm.allreduce(float(nodes[:, 2].max(initial=-np.inf)), MPI.MAX)
        self._at = nodes[:, [0, 2]] - [0.0, low]
        place = (SLICES * self._at[:, 1] / (high - low)).astype(int)
        self._slice = np.clip(place, 0, SLICES - 1)
        self._first_deg = 0.0
        count, x, z, square = self._sums(np.ones(len(nodes)), *self._at.T, (self._at**2).sum(1))
        inertia = square - (x**2 + z**2) / np.maximum(count, 1)
        self._count = count
        self._known = inertia > FLAT * count * (high - low) ** 2

    def _sums(self, *values: np.ndarray) -> np.ndarray:
        """Sums over each slice of k values at the nodes, shape (k, slices)."""
        local = [np.bincount(self._slice, each, SLICES) for each in values]
        return np.asarray(self._model.comm.allreduce(np.array(local), MPI.SUM))

    def deg(self) -> np.ndarray:
        """(m,) rotations of the slices that have nodes, from the clamp on, without jumps."""
        x, z = self._at.T
        moved = self._model.u.x.array.reshape(-1, 3)[: len(x)]
        now_x, now_z = x + moved[:, 0], z + moved[:, 2]
        sum_x, sum_z, sum_now_x, sum_now_z, cross, dot = self._sums(
            x, z, now_x, now_z, x * now_z - z * now_x, x * now_x + z * now_z
        )[:, self._known]
        count = self._count[self._known]
        cross -= (sum_x * sum_now_z - sum_z * sum_now_x) / count
        dot -= (sum_x * sum_now_x + sum_z * sum_now_z) / count
        found = np.degrees(np.arctan2(cross, dot))
        found[0] += 360.0 * round((self._first_deg - found[0]) / 360.0)
        self._first_deg = float(found[0])
        return np.asarray(np.unwrap(found, period=360.0))
