"""Rotations of slices of a finger and of its tip face, also beyond half a turn."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from scipy.spatial.transform import Rotation

from dolfingrip.channels import BENDING_ANGLE, BENDING_DIRECTION, TIP_ROTATION, TIP_ROTATIONS
from dolfingrip.forms import tip_face
from dolfingrip.mechanics.model.assembly import integral, undeformed
from dolfingrip.mechanics.model.model import Model

SLICES = 24
"""Number of slices along the length: neighbours of a finger that curls twice differ by 30°."""

FLAT = 1e-9
"""Smallest moment of inertia of a slice, divided by its number of nodes and the length squared."""

STRAIGHT_DEG = 1e-9
"""Bending below which there is no direction."""


class Slices:
    """Slices of a body along z, from its clamped end to its tip.

    Args:
        model: model that is read; its clamped end has the smallest z.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._at = model.nodes_mm
        low, high = model.box_mm[:, 2]
        place = (SLICES * (self._at[:, 2] - low) / (high - low)).astype(int)
        self._slice = np.clip(place, 0, SLICES - 1)
        count, at_rest = self._moments(np.zeros_like(self._at))
        self._known = at_rest[:, 0, 0] + at_rest[:, 2, 2] > FLAT * count * (high - low) ** 2
        self._first_deg = 0.0

    def _moments(self, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of nodes (s,) and moments (s, 3, 3) of the slices, displaced by (n, 3)."""
        return moments(self._model, self._at, moved, self._slice, SLICES)

    def fits(self) -> np.ndarray:
        """Moments (:func:`moments`) of the slices at the present state, (s, 3, 3)."""
        moved = self._model.u.x.array.reshape(-1, 3)[: len(self._at)]
        return self._moments(moved)[1]

    def deg(self) -> np.ndarray:
        """Rotations (deg) about y, towards −x, of the slices that have nodes, without jumps, (m,).

        The rotation of a slice is the rotation nearest to the motion of its displacement nodes by
        least squares: θ = atan2(Σ (x z' − z x'), Σ (x x' + z z')), with coordinates from their
        means. Whole turns are missing in it. From slice to slice it changes by less than half a
        turn, so the present state tells the turns of all slices but the first. The first slice, at
        the clamp, keeps the turn in which it was last.
        """
        fits = self.fits()[self._known]
        cross, dot = fits[:, 2, 0] - fits[:, 0, 2], fits[:, 0, 0] + fits[:, 2, 2]
        turns_deg = np.degrees(np.arctan2(cross, dot))
        turns_deg[0] += 360.0 * round((self._first_deg - turns_deg[0]) / 360.0)
        self._first_deg = float(turns_deg[0])
        return np.asarray(np.unwrap(turns_deg, period=360.0))


def moments(
    model: Model, rest_mm: np.ndarray, moved: np.ndarray, group: np.ndarray, groups: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sums over groups of nodes of all ranks.

    Args:
        model: that the nodes belong to.
        rest_mm, moved: (n, 3) places and displacements of this rank's nodes (mm).
        group: (n,) group of each node.
        groups: their number g.

    Returns:
        Numbers of nodes (g,), and (g, 3, 3) Σ x Xᵀ (mm²) about the means of the displaced and
        undeformed nodes.
    """
    now = rest_mm + moved
    products = (now[:, :, None] * rest_mm[:, None]).reshape(-1, 9)
    columns = np.column_stack([products, now, rest_mm, np.ones(len(rest_mm))])
    local = np.array([np.bincount(group, values, groups) for values in columns.T])
    total = np.asarray(model.comm.allreduce(local, MPI.SUM)).T
    sums, count = total[:, :9].reshape(-1, 3, 3), total[:, -1]
    means = total[:, 9:15].reshape(-1, 2, 3)
    if model.domain.half:  # the image's parts along y have the other sign
        means[:, :, 1] = 0.0
        sums[:, 1, [0, 2]] = sums[:, [0, 2], 1] = 0.0
    apart = means[:, 0, :, None] * means[:, 1, None] / np.maximum(count, 1)[:, None, None]
    return count, sums - apart


class TipRotation:
    """Rotation of the tip face since rest, with whole turns.

    It is the least rotation that turns the face's area vector as it has turned, followed by the
    rotation about this vector that fits the face's nodes best. So in the plane of bending it is the
    angle that :class:`~dolfingrip.mechanics.readings.tip.FaceAngle` reads. Whole turns are those
    that add up along slices of the finger.

    Args:
        model: model that is read.
        slices: of it.
    """

    def __init__(self, model: Model, slices: Slices) -> None:
        self._model, self._slices = model, slices
        space = model.u.function_space
        tip = fem.locate_dofs_topological(space, 2, model.domain.facets("tip"))
        self._tip = tip[tip < space.dofmap.index_map.size_local]
        self._at = space.tabulate_dof_coordinates()[self._tip]
        degree = 2 * space.ufl_element().degree
        face = model.domain.surface("tip", quadrature_degree=degree)
        vector = tip_face.area_vector(model.u, model.domain.mesh)
        self._area = [vector[i] * face for i in range(3)]
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
    def _at_rest(self) -> np.ndarray:
        """Unit area vector of the undeformed face, (3,)."""
        with undeformed(self._model.u):
            return self._normal()

    def _normal(self) -> np.ndarray:
        normal = np.array([integral(form) for form in self._area])
        if self._model.domain.half:
            normal[1] = 0.0
        return normal / np.linalg.norm(normal)

    def _face(self) -> np.ndarray:
        """Rotation of the tip face from the undeformed one, (3, 3)."""
        start = self._at_rest
        normal = self._normal()
        swing = _swing(start, normal).as_matrix()
        moved, one = self._model.u.x.array.reshape(-1, 3)[self._tip], np.zeros_like(self._tip)
        _, (fit,) = moments(self._model, self._at, moved, one, 1)
        spread = fit @ swing.T
        turn = np.trace(spread) - normal @ spread @ normal
        off = np.array([spread[2, 1] - spread[1, 2], spread[0, 2] - spread[2, 0],
                        spread[1, 0] - spread[0, 1]])  # fmt: skip
        twist = Rotation.from_rotvec(np.arctan2(off @ normal, turn) * normal)
        return np.asarray(twist.as_matrix() @ swing)

    def _along(self) -> np.ndarray:
        """Sum of the slices' rotation vectors (rad), each from the one before it, (3,)."""
        turns = [_nearest(fit) for fit in self._slices.fits()]
        fitted = [turn for turn in turns if turn is not None]
        steps = [Rotation.from_matrix(b @ a.T) for a, b in pairwise(fitted)]
        first = Rotation.from_matrix(fitted[0]).as_rotvec()
        return np.asarray(first + sum((step.as_rotvec() for step in steps), np.zeros(3)))


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
