"""The middle line of a finger's back, deformed: places on it, its curvature, a curve's distance."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Final

import numpy as np
from scipy.spatial import ConvexHull, Delaunay

from dolfingrip.channels import CURVE, CURVE_PARTS, PRESSURE, curvature, marker
from dolfingrip.mechanics.model.model import Model, Prescribed
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.reading import Reading
from dolfingrip.sections.curve import CurveTarget
from dolfingrip.sections.errors import ConfigError

LEVEL = 1e-6
"""A node lies on the line if its distance, relative to the line's length, is smaller than this."""

PLANE: Final = np.array([0, 2])
"""Coordinates of the plane of bending: x and z."""

SHEAR: Final = np.array([[1.0, 0.05], [0.0, 1.0]])

# a side's normal has this part at least along y; that of a round body reaches to its back
FACING: Final = 0.01

# a marker may stand off the side by this part of the finger's length: a ball of motion capture
OFF: Final = 0.05

Floats = np.ndarray

Function = Callable[[Floats], tuple[float, Floats]]
"""From places (n, 2), x and z (mm), to a number and its derivatives (n, 2)."""


@dataclass(frozen=True, slots=True)
class _Places:
    """Places on the deformed line.

    Attributes:
        points: (n, 2), x and z (mm).
        along: (n, 2), their change with the place at rest; on the side, where a point moves in two
            directions, (n, 2, 2).
        weights: (n, nodes), shares of the line's nodes.
    """

    points: Floats
    along: Floats
    weights: Floats


class BackLine:
    """Nodes along the middle of the back, where x is lowest and y is 0, from the clamp to the tip.

    Between nodes the displacement is that of the elements, whose edges lie on the line.

    Args:
        model: of a finger.

    Raises:
        ConfigError: one line, where the mesh has no edges there.
    """

    def __init__(self, model: Model) -> None:
        self._model, self._comm = model, model.comm
        nodes, box = model.nodes_mm, model.box_mm
        length = np.ptp(box[:, 2])
        near = np.abs(nodes[:, :2] - [box[0, 0], 0.0]).max(axis=1) < LEVEL * length
        z = self._listed(np.flatnonzero(near))[:, 1]
        self._degree = int(model.u.function_space.ufl_element().degree)
        covers = len(z) > 2 and np.ptp(z) > (1 - LEVEL) * length
        if not covers or (len(z) - 1) % self._degree or self._uneven(z):
            raise ConfigError(
                "camera.markers, curve: this mesh has no edges along the middle of the back; "
                "allowed: with mesh.half = true"
            )

    def _listed(self, nodes: np.ndarray) -> Floats:
        """Take nodes of this rank for those of the line; x and z at rest of all, by rising z."""
        every = self._comm.allgather(self._model.nodes_mm[nodes][:, PLANE])
        self._own, places = nodes, np.concatenate(every)
        self._order = np.argsort(places[:, 1], kind="stable")
        first = sum(len(part) for part in every[: self._comm.rank])
        self._rank = slice(first, first + len(nodes))
        return places[self._order]

    def _uneven(self, z: Floats) -> bool:
        """Tell whether nodes between corners are not in the middle, so that a cell is missing."""
        if self._degree == 1:
            return False
        middle = (z[:-2:2] + z[2::2]) / 2
        return bool(np.abs(z[1::2] - middle).max() > LEVEL * np.ptp(z))

    def _gathered(self, local: Floats) -> Floats:
        """Values at all nodes of the line in order, from those at this rank's."""
        return np.asarray(np.concatenate(self._comm.allgather(local))[self._order])

    def at(self, shares: Floats) -> _Places:
        """Places at parts of the line's length at rest, 0 at the clamp to 1 at the tip, (n,)."""
        u = self._model.u
        rest_mm = u.function_space.tabulate_dof_coordinates()[self._own][:, PLANE]
        now = rest_mm + u.x.array.reshape(-1, 3)[self._own][:, PLANE]
        z, positions = self._gathered(rest_mm[:, 1]), self._gathered(now)
        places, degree = z[0] + shares * (z[-1] - z[0]), self._degree
        cell = np.clip(
            np.searchsorted(z[::degree], places, "right") - 1, 0, (len(z) - 1) // degree - 1
        )
        weights, rates = np.zeros((2, len(places), len(z)))
        rows = np.arange(len(places))
        for i in range(degree + 1):
            others = [j for j in range(degree + 1) if j != i]
            z_i = z[degree * cell + i]
            parts = [(places - z[degree * cell + j]) / (z_i - z[degree * cell + j]) for j in others]
            weights[rows, degree * cell + i] = np.prod(parts, axis=0)
            rates[rows, degree * cell + i] = sum(
                np.prod([parts[k] for k in range(degree) if k != n], axis=0)
                / (z_i - z[degree * cell + j])
                for n, j in enumerate(others)
            )
        return _Places(weights @ positions, rates @ positions, weights)

    def own(self, at_nodes: Floats) -> Floats:
        """Rows of this rank's nodes, of values at all nodes in order."""
        rows = np.empty_like(at_nodes)
        rows[self._order] = at_nodes
        return np.asarray(rows[self._rank])

    @property
    def rows(self) -> Floats:
        """Numbers of this rank's nodes on the line among its displacement nodes."""
        return self._own


class SideLine(BackLine):
    """Points of the finger's side, between whose nodes places are linear.

    The side is what a camera sees along y of the body's convex hull, so that a round one has one. A
    point off its edge turns with what is nearest.

    Args:
        model: of a finger.
        places_mm: (n, 2) x and z of the points at rest.

    Raises:
        ConfigError: one line, where a point is not on or near the side.
    """

    def __init__(self, model: Model, places_mm: Floats) -> None:
        self._model, self._comm, self._places = model, model.comm, places_mm
        nodes, length = model.nodes_mm, float(np.ptp(model.box_mm[:, 2]))
        planes = ConvexHull(np.concatenate(self._comm.allgather(nodes))).equations
        planes = np.unique(planes[planes[:, 1] > FACING].round(9), axis=0)
        level = reduce(np.maximum, (nodes @ plane[:3] + plane[3] for plane in planes))
        side = self._listed(np.flatnonzero(level > -LEVEL * length))
        off = np.array([-1, 1])[:, None] * OFF * length
        low, high = (np.array([side.min(axis=0), side.max(axis=0)]) + off).round(3)
        outside = ((places_mm < low) | (places_mm > high)).any(axis=1)
        outside |= self._triangles(side)[1] < 0
        if outside.any():
            x, z = places_mm[int(np.argmax(outside))]
            raise ConfigError(
                f"camera.markers: [{x:g}, {z:g}] is not on the finger's side; allowed: x from "
                f"{low[0]:g} to {high[0]:g} mm and z from {low[1]:g} to {high[1]:g} mm"
            )

    def _triangles(self, side: Floats) -> tuple[Delaunay, Floats]:
        """Triangles between nodes (n, 2) of the side at rest, and the one that each point is in."""
        # a rectangle of nodes has one shorter diagonal then, also where it is changed a little
        triangles = Delaunay(side @ SHEAR)
        nearest = np.clip(self._places, side.min(axis=0), side.max(axis=0))
        return triangles, triangles.find_simplex(nearest @ SHEAR, tol=LEVEL)

    def at(self, shares: Floats) -> _Places:
        """Places of the points with these numbers, (n,)."""
        u = self._model.u
        rest_mm = u.function_space.tabulate_dof_coordinates()[self._own][:, PLANE]
        positions = self._gathered(rest_mm + u.x.array.reshape(-1, 3)[self._own][:, PLANE])
        triangles, every = self._triangles(self._gathered(rest_mm))
        numbers = shares.astype(int)
        inside = every[numbers]
        turned, corners = triangles.transform[inside], triangles.simplices[inside]
        away = self._places[numbers] @ SHEAR - turned[:, 2]
        parts = np.einsum("nij,nj->ni", turned[:, :2], away)
        weights = np.zeros((len(numbers), len(positions)))
        rows = np.arange(len(numbers))[:, None]
        weights[rows, corners] = np.column_stack([parts, 1 - parts.sum(axis=1)])
        rates = turned[:, :2] @ SHEAR.T
        rates = np.append(rates, -rates.sum(axis=1, keepdims=True), axis=1)
        along = np.einsum("nki,nkj->nij", positions[corners], rates)
        return _Places(weights @ positions, along, weights)


class OfLine(Reading):
    """A number of the places at some parts of the line's length.

    Args:
        line: of the model that is read.
        model: that is read.
        column: name in the table, with the unit.
        shares: (n,) parts of the length at rest, 0 to 1.
        function: of the places there.
    """

    def __init__(
        self, line: BackLine, model: Model, column: str, shares: Floats, function: Function
    ) -> None:
        super().__init__(model, column)
        self._line, self._shares, self._function = line, shares, function

    def value(self) -> float:
        return self._function(self._line.at(self._shares).points)[0]

    def add_gradient(self, gradient: Gradient) -> None:
        here = self._line.at(self._shares)
        by_nodes = self._line.own(here.weights.T @ self._function(here.points)[1])
        gradient.at_nodes[np.ix_(self._line.rows, PLANE)] += by_nodes

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        """Add derivatives by nodes' places at rest, at which places on the line are fixed."""
        here = self._line.at(self._shares)
        slopes = self._function(here.points)[1]
        passed = (slopes * here.along).sum(axis=1)  # of a place that moves along the line
        by_nodes = here.weights.T @ slopes
        by_nodes[:, 1] -= here.weights.T @ passed
        by_nodes[[0, -1], 1] += (1 - self._shares) @ passed, self._shares @ passed
        gradient.at_nodes[np.ix_(self._line.rows, PLANE)] += self._line.own(by_nodes)


class OfSide(OfLine):
    """A number of the places of some points of the side, which are told by their places at rest."""

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        """Add derivatives by nodes' places at rest, in which the points do not move."""
        here = self._line.at(self._shares)
        slopes = self._function(here.points)[1]
        by_nodes = here.weights.T @ (slopes - np.einsum("ni,nij->nj", slopes, here.along))
        gradient.at_nodes[np.ix_(self._line.rows, PLANE)] += self._line.own(by_nodes)


def _coordinate(axis: int) -> Function:
    slopes = np.eye(2)[[axis]]
    return lambda points: (float(points[0, axis]), slopes)


def _curvature(points: Floats) -> tuple[float, Floats]:
    """Turn (1/m) at the second of three points for each length, positive towards −x."""
    before, after = np.diff(points, axis=0)
    lengths = np.linalg.norm([before, after], axis=1)
    turn = math.atan2(before[0] * after[1] - before[1] * after[0], float(before @ after))
    mean = lengths.mean()
    by_before = np.array([before[1], -before[0]]) / lengths[0] ** 2
    by_after = np.array([-after[1], after[0]]) / lengths[1] ** 2
    value = 1e3 * turn / mean
    by_before = 1e3 * by_before / mean - value / mean * before / lengths[0] / 2
    by_after = 1e3 * by_after / mean - value / mean * after / lengths[1] / 2
    return value, np.array([-by_before, by_before - by_after, by_after])


class _Distances:
    """Distances of places of the line from a curve, or of the tip from its way over pressure.

    Args:
        curve: of the configuration.
        pressure: in the finger.
    """

    def __init__(self, curve: CurveTarget, pressure: Prescribed) -> None:
        self._target, self._pressure = curve.targets(), pressure
        self._of_tip, self._fixed = curve.of_tip, curve.ends == "fixed"
        self.shares = np.ones(1) if curve.of_tip else np.linspace(0, 1, curve.places + 1)

    def _away(self, points: Floats) -> tuple[Floats, Callable[[Floats], Floats]]:
        """Vectors (n, 2) from the curve, and the derivatives by places from those by them."""
        target = self._target(self._pressure.value)
        if self._of_tip:
            return points - target.points, lambda slopes: slopes
        if not self._fixed:
            nearest, moved = target.nearest(points)
            return points - nearest, lambda slopes: slopes - np.einsum("kij,kj->ki", moved, slopes)
        steps = np.diff(points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        along = np.concatenate([[0.0], np.cumsum(lengths)])
        shares = along / along[-1]
        rates = target.rates(shares)

        def by_places(slopes: Floats) -> Floats:
            by_shares = -(slopes * rates).sum(axis=1)
            after = np.cumsum(by_shares[::-1])[::-1][1:]  # of places beyond each step
            by_lengths = (after - by_shares @ shares) / along[-1]
            turned = (by_lengths / lengths)[:, None] * steps
            derivatives = slopes.copy()
            derivatives[1:] += turned
            derivatives[:-1] -= turned
            return derivatives

        return points - target.at(shares), by_places

    def mean_square(self, points: Floats) -> tuple[float, Floats]:
        """The mean of their squares (mm²)."""
        away, by_places = self._away(points)
        return float((away**2).sum() / len(away)), by_places(2 * away / len(away))

    def part(self, number: int) -> Function:
        """The part (mm) along x or z that has the form of a Legendre polynomial.

        The squares of all parts add up to the mean square.
        """
        degree, axis = divmod(number - 1, 2)
        shape = np.polynomial.legendre.Legendre.basis(degree)(2 * self.shares - 1)
        weights = np.outer(shape * math.sqrt(2 * degree + 1) / len(shape), np.eye(2)[axis])

        def function(points: Floats) -> tuple[float, Floats]:
            away, by_places = self._away(points)
            return float((weights * away).sum()), by_places(weights)

        return function


def part_of_distance(model: Model, curve: CurveTarget, column: str) -> OfLine:
    """Make the reading of a part of the distances from a curve, by which a descent is steered.

    Args:
        model: of a finger.
        curve: whose distances they are.
        column: one of :data:`~dolfingrip.channels.CURVE_PARTS`.
    """
    distances = _Distances(curve, model.controls[PRESSURE.name])
    function = distances.part(CURVE_PARTS.index(column) + 1)
    return OfLine(BackLine(model), model, column, distances.shares, function)


def of_line(
    model: Model, markers: int | Sequence[tuple[float, float]], curve: CurveTarget | None
) -> Sequence[Reading]:
    """Make the readings of the back's middle line that a configuration asks for.

    Args:
        model: of a finger.
        markers: number of markers at equal distances from the clamp to the tip, where the last one
            is; or places (mm) of markers on the side at rest, x and z.
        curve: whose distance is read; None: none.

    Returns:
        Places of all markers, curvatures at those between others, and the distance.

    Raises:
        ConfigError: one line, where the mesh has no edges along the line.
    """
    if not markers and curve is None:
        return []
    readings: list[Reading] = []
    kind: type[OfLine] = OfLine
    if isinstance(markers, int):
        count, line = markers, BackLine(model)
        shares = np.arange(1, count + 1) / max(count, 1)
    else:
        kind, count, line = OfSide, len(markers), SideLine(model, np.asarray(markers))
        shares = np.arange(count, dtype=float)
    for i, share in enumerate(shares, 1):
        for axis, letter in enumerate("xz"):
            name = marker(i, letter).name
            readings.append(kind(line, model, name, np.array([share]), _coordinate(axis)))
    for i in range(2, count):
        name = curvature(i).name
        readings.append(kind(line, model, name, shares[i - 2 : i + 1], _curvature))
    if curve is not None:
        distances = _Distances(curve, model.controls[PRESSURE.name])
        back = BackLine(model)
        readings.append(OfLine(back, model, CURVE.name, distances.shares, distances.mean_square))
    return readings
