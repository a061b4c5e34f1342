"""Rotation of the tip face in space: how far and which way a finger bends, and its twist."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from scipy.spatial.transform import Rotation

from dolfingrip.channels import BENDING_ANGLE, BENDING_DIRECTION, TIP_ROTATION, TIP_ROTATIONS
from dolfingrip.forms import tip_face
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.model import Model

SLICES = 24
"""Number of slices along the length: neighbours of a finger that curls twice differ by 30°."""

STRAIGHT_DEG = 1e-9
"""Bending below which there is no direction."""


class TipRotation:
    """Rotation of the tip face since rest, with whole turns.

    It is the least rotation that turns the face's area vector as it has turned, followed by the
    rotation about this vector that fits the face's nodes best. So in the plane of bending it is the
    angle that :class:`~dolfingrip.mechanics.readings.tip.FaceAngle` reads. Whole turns are those
    that add up along slices of the finger.

    Args:
        model: model that is read; its clamped end has the smallest z.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        space = model.u.function_space
        own = space.dofmap.index_map.size_local
        self._at = space.tabulate_dof_coordinates()[:own]
        z = self._at[:, 2]
        low = model.comm.allreduce(float(z.min(initial=np.inf)), MPI.MIN)
        high = model.comm.allreduce(float(z.max(initial=-np.inf)), MPI.MAX)
        slices = np.clip((SLICES * (z - low) / (high - low)).astype(int), 0, SLICES - 1)
        tip = fem.locate_dofs_topological(space, 2, model.domain.facets("tip"))
        self._bodies = [*(np.flatnonzero(slices == i) for i in range(SLICES)), tip[tip < own]]
        self._rest, self._turned_rad = np.eye(3), np.zeros(3)

    def tare(self) -> None:
        """Make the present state the state at rest."""
        self._turned_rad = np.zeros(3)
        self._rest, self._turned_rad = self._face().T, self._along()

    def values(self) -> dict[str, float]:
        """Rotation vector and its size, bending angle and direction (deg) by column."""
        along = self._along() - self._turned_rad
        rotation = self._face() @ self._rest
        normal = self._rest.T @ self._at_rest
        turned = _whole(Rotation.from_matrix(rotation).as_rotvec(), along)
        bent = _whole(_swing(normal, rotation @ normal).as_rotvec(), along)
        size = float(np.degrees(np.linalg.norm(bent)))
        direction = float(np.degrees(np.arctan2(-bent[0], -bent[1])))
        named = zip(TIP_ROTATIONS, np.degrees(turned), strict=True)
        return {
            TIP_ROTATION.name: float(np.degrees(np.linalg.norm(turned))),
            **{channel.name: float(value) for channel, value in named},
            BENDING_ANGLE.name: size,
            BENDING_DIRECTION.name: direction if size > STRAIGHT_DEG else float("nan"),
        }

    @cached_property
    def _forms(self) -> list[fem.Form]:
        model = self._model
        degree = 2 * model.u.function_space.ufl_element().degree
        tip = model.domain.surface("tip", quadrature_degree=degree)
        vector = tip_face.area_vector(model.u, model.domain.mesh)
        return [fem.form(vector[i] * tip, jit_options=jit.options()) for i in range(3)]

    @cached_property
    def _at_rest(self) -> np.ndarray:
        """(3,) unit area vector of the undeformed face."""
        u = self._model.u.x.array
        now = u.copy()
        u[:] = 0.0
        found = self._normal()
        u[:] = now
        return found

    def _normal(self) -> np.ndarray:
        local = np.array([fem.assemble_scalar(form) for form in self._forms])
        found = np.asarray(self._model.comm.allreduce(local, MPI.SUM))
        if self._model.domain.half:
            found[1] = 0.0
        return found / np.linalg.norm(found)

    def _face(self) -> np.ndarray:
        """(3, 3) rotation of the tip face from the undeformed one."""
        start = self._at_rest
        normal = self._normal()
        swing = _swing(start, normal).as_matrix()
        spread = self._fit(self._bodies[-1]) @ swing.T
        turn = np.trace(spread) - normal @ spread @ normal
        off = np.array([spread[2, 1] - spread[1, 2], spread[0, 2] - spread[2, 0],
                        spread[1, 0] - spread[0, 1]])  # fmt: skip
        twist = Rotation.from_rotvec(np.arctan2(off @ normal, turn) * normal)
        return np.asarray(twist.as_matrix() @ swing)

    def _along(self) -> np.ndarray:
        """(3,) sum of the slices' rotation vectors (rad), each from the one before it."""
        turns = [_nearest(self._fit(nodes)) for nodes in self._bodies[:-1]]
        known = [turn for turn in turns if turn is not None]
        steps = [Rotation.from_matrix(b @ a.T) for a, b in pairwise(known)]
        first = Rotation.from_matrix(known[0]).as_rotvec()
        return np.asarray(first + sum((step.as_rotvec() for step in steps), np.zeros(3)))

    def _fit(self, nodes: np.ndarray) -> np.ndarray:
        """(3, 3) Σ x Xᵀ about the means of the displaced and undeformed nodes, of all ranks."""
        rest, moved = self._at[nodes], self._model.u.x.array.reshape(-1, 3)[nodes]
        now = rest + moved
        local = np.concatenate([now.T @ rest, [now.sum(axis=0), rest.sum(axis=0)]])
        total = np.asarray(self._model.comm.allreduce(local, MPI.SUM))
        count = self._model.comm.allreduce(len(nodes), MPI.SUM)
        found, means = total[:3], total[3:].copy()
        if self._model.domain.half:  # the image's parts along y have the other sign
            means[:, 1] = 0.0
            found[1, [0, 2]] = found[[0, 2], 1] = 0.0
        return np.asarray(found - np.outer(*means) / max(count, 1))


def _swing(start: np.ndarray, end: np.ndarray) -> Rotation:
    """The least rotation from one unit vector to another."""
    axis = np.cross(start, end)
    size = float(np.linalg.norm(axis))
    angle = np.arctan2(size, float(start @ end))
    if size == 0.0:
        # half a turn about any axis across; a finger's is y
        return Rotation.from_rotvec(angle * np.array([0.0, 1.0, 0.0]))
    return Rotation.from_rotvec(angle / size * axis)


def _nearest(fit: np.ndarray) -> np.ndarray | None:
    """The rotation that is nearest to a moment matrix; None if it tells none."""
    left, sizes, right = np.linalg.svd(fit)
    if sizes[1] <= 1e-9 * max(sizes[0], 1e-300):
        return None
    sign = np.sign(np.linalg.det(left @ right))
    return np.asarray(left @ np.diag([1.0, 1.0, sign]) @ right)


def _whole(vector: np.ndarray, along: np.ndarray) -> np.ndarray:
    """A rotation vector (rad) with the whole turns that bring it nearest to another vector."""
    size = float(np.linalg.norm(vector))
    if size == 0.0:
        return vector
    turns = round((float(along @ vector) / size - size) / (2 * np.pi))
    return np.asarray(vector * (1 + 2 * np.pi * turns / size))
