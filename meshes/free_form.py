"""Free form: the planes of a finger's faces, each bent by a spline over it.

All faces of a finger of boxes lie in planes x, y or z = const. A dimension moves a plane as a whole
(:mod:`dolfingrip.meshes.dimensions`); a free form adds to each plane an offset that varies over it.
Points between two planes keep their relative position, so walls, gaps and the mesh inside them
follow, on a mesh of any kind and resolution.

The field over a plane across x or y is a product of two functions across the finger and quadratic
B-splines along z. That over a plane across z is a product of two functions in x and two in y. The
functions in y are even, so that both halves of the finger are mirror images.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from dolfingrip.meshes.dimensions import followed, moved
from dolfingrip.meshes.solid import Floats, SolidMesh
from dolfingrip.sections.form import DEGREE, Form
from dolfingrip.sections.geometry.geometry import Geometry

_ROUNDS, _CLOSE_MM = 60, 1e-13


class FreeForm:
    """The motion of points that a free form asks for.

    Args:
        geometry: of boxes, with the planes that are bent. Where chambers have dimensions of their
            own, a point moves as the one does that it is in the finger with the shared ones.
        form: the offsets; None: no point moves.

    Attributes:
        offsets_mm: shape (count,).
    """

    def __init__(self, geometry: Geometry, form: Form | None) -> None:
        solid = geometry.boxes()
        assert solid is not None  # the configuration refuses a free form of another one
        self._geometry = geometry
        self._body, self._along = solid.body, 0 if form is None else form.along
        self.offsets_mm = np.array(() if form is None else form.offsets_mm, dtype=float)
        self._planes = []
        for axis, (low, high) in enumerate(solid.body):
            bent = solid.bent(axis) if form is None else form.planes(solid, axis)
            still = 0.0 if axis == 1 else low
            if axis == 0 and form is not None and form.contact_face:
                still -= high - low  # below all points, so that no plane of theirs stays
            self._planes.append(np.array([still, *bent, *([high] if axis == 2 else [])]))

    # -- motions ---------------------------------------------------------------------------------

    def points(self, points: Floats) -> Floats:
        """Moved points, (n, 3) mm, of points before any morph."""
        if not self.offsets_mm.any():
            return points.copy()
        return np.asarray(points + (self.slopes(points) @ self.offsets_mm).reshape(-1, 3))

    def inverse(self, points: Floats) -> Floats:
        """The points that :meth:`points` moves to ``points``, (n, 3) mm."""
        straight = points.copy()
        if not self.offsets_mm.any():
            return straight
        for _ in range(_ROUNDS):
            before = straight.copy()
            if self._geometry.differ:
                straight = points - (self.points(straight) - straight)
            for axis in () if self._geometry.differ else range(3):
                straight[:, axis] = self._back(points[:, axis], straight, axis)
            if np.abs(straight - before).max(initial=0.0) < _CLOSE_MM:
                break
        return straight

    def slopes(self, points: Floats) -> sp.csr_matrix:
        """Derivatives (3 n, count) of the moved points by the offsets; row 3 i + a is point i's."""
        if self._geometry.differ:
            points = moved(points, self._geometry, self._geometry.alike())
        parts, start = [], 0
        for axis in range(3):
            fields = self._fields(points, axis)
            rows, columns, values = self._near(points[:, axis], axis)
            size = fields.shape[1]
            bent = columns >= 0
            rows, columns, values = rows[bent], columns[bent], values[bent]
            parts.append(
                (
                    np.repeat(3 * rows + axis, size),
                    (start + columns[:, None] * size + np.arange(size)).ravel(),
                    (values[:, None] * fields[rows]).ravel(),
                )
            )
            start += (len(self._planes[axis]) - 1 - (axis == 2)) * size
        row, column, value = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        return sp.csr_matrix((value, (row, column)), shape=(3 * len(points), start))

    # -- inside ----------------------------------------------------------------------------------

    def _near(self, coordinate: Floats, axis: int) -> tuple[np.ndarray, np.ndarray, Floats]:
        """Points, planes beside them and the planes' shares in their motion.

        A plane's number counts those that are bent; it is −1 for one that stays.
        """
        planes = self._planes[axis]
        at = np.abs(coordinate) if axis == 1 else coordinate
        sign = np.where(coordinate < 0, -1.0, 1.0) if axis == 1 else np.ones(len(at))
        below = np.clip(np.searchsorted(planes, at, side="right") - 1, 0, len(planes) - 2)
        share = (at - planes[below]) / (planes[below + 1] - planes[below])
        rows = np.arange(len(at))
        numbers = np.concatenate([below - 1, below])
        if axis == 2:
            numbers[numbers == len(planes) - 2] = -1
        values = np.concatenate([sign * (1 - share), sign * share])
        return np.concatenate([rows, rows]), numbers, values

    def _fields(self, points: Floats, axis: int) -> Floats:
        """Values (n, numbers of a plane) of the functions over a plane across ``axis``."""
        (low, high), (_, wide), (start, end) = self._body
        s = (points[:, 0] - low) / (high - low)
        t = (points[:, 1] / wide) ** 2
        in_x, in_y = np.stack([1 - s, s], axis=1), np.stack([1 - t, t], axis=1)
        if axis == 2:
            return np.einsum("ni,nj->nij", in_x, in_y).reshape(len(points), -1)
        z = np.clip((points[:, 2] - start) / (end - start), 0.0, 1.0)
        inner = np.linspace(0, 1, self._along - DEGREE + 1)
        knots = np.concatenate([np.zeros(DEGREE), inner, np.ones(DEGREE)])
        from scipy.interpolate import BSpline

        along = BSpline.design_matrix(z, knots, DEGREE).toarray()
        across = in_y if axis == 0 else in_x
        return np.einsum("ni,nj->nij", across, along).reshape(len(points), -1)

    def _back(self, coordinate: Floats, near: Floats, axis: int) -> Floats:
        """Coordinates before the motion along ``axis``, whose planes are bent as at ``near``."""
        planes = self._planes[axis]
        fields = self._fields(near, axis)
        size = fields.shape[1]
        start = 0
        for before in range(axis):
            width = self._fields(near[:1], before).shape[1]
            start += (len(self._planes[before]) - 1 - (before == 2)) * width
        count = len(planes) - 1 - (axis == 2)
        offsets = self.offsets_mm[start : start + count * size].reshape(count, size)
        flat = np.tile(planes, (len(near), 1))
        moved = flat.copy()
        moved[:, 1 : 1 + count] += fields @ offsets.T
        at = np.abs(coordinate) if axis == 1 else coordinate
        straight = followed(at, moved, flat)
        return np.asarray(np.where(coordinate < 0, -straight, straight) if axis == 1 else straight)


def bent(mesh: SolidMesh, form: FreeForm) -> SolidMesh:
    """Bend a mesh by a free form.

    Args:
        mesh: straight mesh (mm).
        form: free form of its walls.

    Returns:
        The mesh with moved points; cells and groups stay.
    """
    if not form.offsets_mm.any():
        return mesh
    return replace(mesh, points=form.points(mesh.points))
