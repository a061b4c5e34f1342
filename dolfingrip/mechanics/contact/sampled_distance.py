"""A signed distance as a tricubic spline through samples on a grid."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from itertools import combinations_with_replacement, product
from typing import Self

import numpy as np
from scipy import ndimage

from dolfingrip.mechanics.contact.distance import Bounds, Distances

SUPPORT = 4
"""Number of coefficients of a cubic B-spline along each axis that act on a point."""


BEZIER = (
    np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6,
    np.array([[-3, 0, 3, 0], [-1, -4, 5, 0], [0, -5, 4, 1], [0, -3, 0, 3]]) / 6,
    np.array([[3, -6, 3, 0], [2, -3, 0, 1], [1, 0, -3, 2], [0, 3, -6, 3]]) / 3,
)
"""Matrix (4, 4) from the coefficients that a cell feels to the control points of the cubic there,
of its first derivative, and of its second, all as cubics."""


class SampledDistance:
    """φ = Σ c_ijk B(x/h − i) B(y/h − j) B(z/h − k), B the cubic B-spline: twice differentiable.

    The spline passes through the samples (Unser, Splines: A Perfect Fit for Signal and Image
    Processing, 1999). Beyond the grid the distance is the smallest one on the grid's box plus the
    distance from the box, which is never more than the true distance.

    Its slope is 1 apart from errors of the samples and of the spline. Its control points in each
    cell bound how much steeper or more concave it may be anywhere outside the shape.

    Args:
        samples: (l, m, n) distances (mm), :data:`SUPPORT` or more along each axis, positive on
            the grid's faces.
        origin_mm: (3,) place of the first sample.
        spacing_mm: h.
        bounded_cells: distance from the surface, in cells, within which second derivatives are
            bounded.
    """

    def __init__(
        self,
        samples: np.ndarray,
        origin_mm: np.ndarray,
        spacing_mm: float,
        bounded_cells: float = 2.0,
    ) -> None:
        self._bounded_cells = bounded_cells
        filtered = ndimage.spline_filter(samples, order=3, mode="mirror", output=float)
        self._coefficients = np.pad(filtered, 1, mode="reflect")
        self._count = np.array(samples.shape)
        self.origin_mm = np.asarray(origin_mm, dtype=float)
        self.spacing_mm = float(spacing_mm)
        faces = [samples.take(end, axis=axis) for axis in range(3) for end in (0, -1)]
        self._least = float(min(face.min() for face in faces))
        if self._least <= 0:
            raise ValueError(f"distance on the grid's faces {self._least:.3g} mm: above 0 needed")

    @classmethod
    def of(
        cls,
        distance: Callable[[np.ndarray], np.ndarray],
        low_mm: np.ndarray,
        high_mm: np.ndarray,
        spacing_mm: float,
        smoothing_mm: float = 0.0,
    ) -> Self:
        """A function of (n, 3) points, sampled between two corners.

        Args:
            distance: (n,) signed distances.
            low_mm: (3,) corner of the grid; :attr:`margin_mm` or more away from the shape.
            high_mm: (3,) opposite corner, which the grid reaches or passes.
            spacing_mm: spacing of the samples.
            smoothing_mm: standard deviation of the Gaussian that rounds edges off.
        """
        low = np.asarray(low_mm, dtype=float)
        count = np.maximum(np.ceil((high_mm - low) / spacing_mm).astype(int) + 1, SUPPORT)
        axes = [start + spacing_mm * np.arange(n) for start, n in zip(low, count, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        samples = distance(points).reshape(count)
        if smoothing_mm > 0:
            samples = ndimage.gaussian_filter(samples, smoothing_mm / spacing_mm, mode="nearest")
        return cls(samples, low, spacing_mm)

    # -- evaluation ------------------------------------------------------------------------------

    def at(self, points: np.ndarray) -> Distances:
        """Distances of (n, 3) points (mm), from the spline or from the grid's box."""
        size = self.spacing_mm * (self._count - 1)
        nearest = np.clip(points, self.origin_mm, self.origin_mm + size)
        apart = points - nearest
        away = np.linalg.norm(apart, axis=1)
        value, gradient, hessian = self._spline(nearest)
        outside = away > 0
        value = np.where(outside, self._least + away, value)
        unit = apart / np.maximum(away, np.finfo(float).tiny)[:, None]
        gradient = np.where(outside[:, None], unit, gradient)
        return Distances(value, gradient, np.where(outside[:, None, None], 0.0, hessian))

    def _spline(self, points: np.ndarray) -> Distances:
        """Value and derivatives of the spline at points within the grid."""
        place = (points - self.origin_mm) / self.spacing_mm
        cell = np.clip(np.floor(place).astype(int), 0, self._count - 2)
        weights = b_splines(place - cell)  # (derivative, n, axis, 4)
        reach = np.arange(SUPPORT)
        i, j, k = (cell[:, axis, None] + reach for axis in range(3))
        local = self._coefficients[i[:, :, None, None], j[:, None, :, None], k[:, None, None, :]]

        def derived(orders: tuple[int, int, int]) -> np.ndarray:
            x, y, z = (weights[order][:, axis] for axis, order in enumerate(orders))
            along = np.einsum("nijk,nk->nij", local, z)
            derivative = np.einsum("nij,nj,ni->n", along, y, x)
            return np.asarray(derivative / self.spacing_mm ** sum(orders))

        one = np.eye(3, dtype=int)
        gradient = np.stack([derived(tuple(one[axis])) for axis in range(3)], axis=1)
        hessian = np.empty((len(points), 3, 3))
        for p, q in combinations_with_replacement(range(3), 2):
            hessian[:, p, q] = hessian[:, q, p] = derived(tuple(one[p] + one[q]))
        return Distances(derived((0, 0, 0)), gradient, hessian)

    # -- bounds ----------------------------------------------------------------------------------

    @cached_property
    def bounds(self) -> Bounds:
        """Bounds on the spline outside the shape, by its control points (Bézier) in each cell."""
        cells = np.lib.stride_tricks.sliding_window_view(self._coefficients, 3 * (SUPPORT,))
        cells = cells.reshape(-1, *3 * (SUPPORT,))
        high, low = cells.max(axis=(1, 2, 3)), cells.min(axis=(1, 2, 3))
        outside = high >= 0
        reach = self._bounded_cells * self.spacing_mm
        near = outside & (low <= reach)
        one = np.eye(3, dtype=int)
        slope = self._largest(cells[outside], list(one))
        pairs = [one[p] + one[q] for p in range(3) for q in range(3)]
        inside = np.argwhere((low <= 0).reshape(self._count - 1))
        corners = inside[:, None] + np.array(list(product((0, 1), repeat=3)))
        places = self.origin_mm + self.spacing_mm * corners.reshape(-1, 3)
        radius = float(np.linalg.norm(places, axis=1).max(initial=0.0))
        return Bounds(max(slope, 1.0), self._largest(cells[near], pairs), reach, radius)

    def _largest(self, cells: np.ndarray, orders: list[np.ndarray]) -> float:
        """Bound on the norm of derivatives of given orders along x, y and z in some cells.

        A polynomial lies in the hull of its control points, and so does a vector of polynomials.
        """
        square = np.zeros(cells.shape)
        for order in orders:
            x, y, z = (BEZIER[axis_order] for axis_order in order)
            points = np.einsum("nijk,ai,bj,ck->nabc", cells, x, y, z, optimize=True)
            square += (points / self.spacing_mm ** int(order.sum())) ** 2
        return float(np.sqrt(square.max(initial=0.0)))


def b_splines(t: np.ndarray) -> np.ndarray:
    """The four cubic B-splines felt at t from 0 to 1 in a cell, and two derivatives.

    Args:
        t: any shape.

    Returns:
        (3, *shape, 4).
    """
    s = 1 - t
    value = [s**3, 3 * t**3 - 6 * t**2 + 4, 3 * s**3 - 6 * s**2 + 4, t**3]
    first = [-3 * s**2, 9 * t**2 - 12 * t, 12 * s - 9 * s**2, 3 * t**2]
    second = [6 * s, 18 * t - 12, 18 * s - 12, 6 * t]
    return np.stack([np.stack(part, axis=-1) for part in (value, first, second)]) / 6
