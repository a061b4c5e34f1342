"""The unloaded shape of a design: mass, centre of gravity, walls, gaps and overhangs, exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.design.gradient.file import CELL_QUALITY, FACING, OVERHANG
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.quantities.shape import ShapeNumbers
from dolfingrip.experiments.derivatives.gradients import MassProperties
from dolfingrip.experiments.rigs.perturbation import velocities
from dolfingrip.experiments.rigs.undeformed import placed, straight
from dolfingrip.meshes.cells import FACET_CORNERS
from dolfingrip.meshes.dimensions import moved
from dolfingrip.meshes.solid import Floats, Ints, SolidMesh
from dolfingrip.meshes.walls import Facing, facing
from dolfingrip.parameter import Entry

BESIDE: Final = {
    4: np.array([[0, 1, 2, 3]]),
    8: np.array(
        [
            [0, 1, 3, 4], [1, 2, 0, 5], [2, 3, 1, 6], [3, 0, 2, 7],
            [4, 7, 5, 0], [5, 4, 6, 1], [6, 5, 7, 2], [7, 6, 4, 3],
        ]
    ),
}  # fmt: skip
"""Corners of a cell, each with the corners that edges join it with, by the number of corners."""

SHORTEST_MM: Final = 1e-6
"""Length of an edge below which it is a point."""

EDGES: Final = 2.0
"""Weight of an edge's length, by that at the start, beside the scaled Jacobian in a cell's quality:
unit vectors along edges do not tell that a cell becomes a sheet."""

PRINTED = ("skin", "cavity")
"""Groups of facets that an overhang is looked for in."""


def _diagonals(facets: Floats) -> tuple[Floats, Floats]:
    """Two vectors across each facet (…, corners, 3), along its sides if it has three corners."""
    ends = ((0, 1), (0, 2)) if facets.shape[-2] == 3 else ((0, 2), (1, 3))
    first, second = (facets[..., end, :] - facets[..., start, :] for start, end in ends)
    return first, second


def _edges(mesh: SolidMesh, chosen: Ints | None = None) -> tuple[Ints, Floats, Floats]:
    """Corners (k, 4) with those beside them, edges (k, 3, 3) and their lengths (k, 3)."""
    corners: Ints = mesh.cells[:, BESIDE[mesh.shape.corners]].reshape(-1, 4)
    every = corners if chosen is None else corners[chosen]
    edges = mesh.points[every[:, 1:]] - mesh.points[every[:, :1]]
    # an edge may shrink to a point in a step that is tried
    return every, edges, np.maximum(np.linalg.norm(edges, axis=2), SHORTEST_MM)


def _measured(mesh: SolidMesh) -> Floats:
    """Determinants of unit vectors along the edges at each corner of each cell, and lengths (mm).

    Shape (4k,): those of the k corners, then of each corner's three edges.
    """
    _, edges, length = _edges(mesh)
    return np.concatenate([np.linalg.det(edges / length[..., None]), length.ravel()])


FINER: Final = 2
"""How often cells are divided along each axis where walls, gaps and cells are looked at: what bends
between the nodes of the mesh must keep limits, too."""


class UnloadedShapes:
    """The unloaded shapes of a problem's designs, all on the mesh of its start.

    Args:
        problem: the nominal condition's finger is looked at.

    Attributes:
        start: configuration of the start.
        mesh: of the start, before any free form.
        finer: the same with cells divided in two along each axis, as limits see it.
    """

    def __init__(self, problem: Problem) -> None:
        self.variables = problem.variables
        self._condition = problem.nominal
        self.start = problem.nominal.config(self.variables, [v.start for v in self.variables])
        adapted = self.start.adapted()
        self.geometry = adapted.geometry
        self.mesh = straight(adapted)
        self.finer = self.mesh
        self.facing = dict.fromkeys(FACING, Facing(np.empty((0, 2, 4, 3))))
        if adapted.mesh.file is None and adapted.hexahedra:
            finer = adapted.changed(mesh={"refine": FINER * adapted.mesh.refine})
            self.finer = straight(finer)
            facings = facing(self.geometry, finer.mesh)
            self.facing = dict(zip(FACING, facings, strict=True))
        self.measured = _measured(self.finer)
        self.corners = len(self.measured) // 4
        self.measured[self.corners :] /= EDGES
        facets = [self.mesh.facets[name] for name in PRINTED if name in self.mesh.facets]
        corners = FACET_CORNERS[facets[0].shape[1]]
        self.printed: Ints = np.concatenate(facets)[:, :corners]
        self.shaped = [v.parameter for v in self.variables if v.parameter.entry is Entry.SHAPE]

    def at(self, values: Sequence[float] | Floats) -> UnloadedShape:
        """The shape of a design.

        Raises:
            ConfigError: one line, where there is no such finger.
        """
        return UnloadedShape(self, self._condition.config(self.variables, list(map(float, values))))


class UnloadedShape:
    """One unloaded shape.

    Args:
        shapes: that it is one of.
        config: of the design.
    """

    def __init__(self, shapes: UnloadedShapes, config: Config) -> None:
        self._all, self.config = shapes, config
        self._adapted = config.adapted()
        self._straight = self._on_planes(shapes.mesh.points)
        self.mesh = replace(shapes.mesh, points=placed(self._straight, config))

    @cached_property
    def _finer(self) -> SolidMesh:
        """The mesh on which cells are looked at."""
        points = self._on_planes(self._all.finer.points)
        return replace(self._all.finer, points=placed(points, self.config))

    def _on_planes(self, points: Floats) -> Floats:
        if self._adapted.mesh.file is not None:
            return points
        return moved(points, self._all.geometry, self._adapted.geometry)

    def _slopes(self, points: Floats) -> Floats:
        """Velocities of straight points, (variables, n, 3)."""
        velocity = np.zeros((len(self._all.variables), len(points), 3))
        by_key = velocities(self._all.shaped, self.config, points) if self._all.shaped else {}
        for row, variable in enumerate(self._all.variables):
            if variable.key in by_key:
                velocity[row] = by_key[variable.key]
        return velocity

    @cached_property
    def _velocity(self) -> Floats:
        return self._slopes(self._straight)

    # -- numbers ---------------------------------------------------------------------------------

    @cached_property
    def _properties(self) -> MassProperties:
        return MassProperties(self.mesh, self.config)

    def value(self, name: str) -> float:
        """Mass (g), COG offset (mm), or the extreme of :meth:`rows`."""
        if name in ShapeNumbers.names:
            return self._properties.value(name)
        rows = self.rows(name)
        if name == OVERHANG:
            return float(rows.max(initial=0.0))
        return float(rows.min(initial=np.inf))

    def gradient(self, name: str) -> Floats:
        """Derivatives of mass or COG offset by the variables."""
        keys = [variable.key for variable in self._all.variables]
        slopes = self._properties.slopes(name, dict(zip(keys, self._velocity, strict=True)))
        return np.array([slopes[key] for key in keys])

    # -- many rows -------------------------------------------------------------------------------

    def rows(self, name: str) -> Floats:
        """All distances of walls or gaps (mm), overhangs of facets (deg), or qualities of cells.

        Shape (rows,). Qualities are scaled Jacobians at corners by those at the start, and twice
        the lengths of edges by those at the start.
        """
        if name == OVERHANG:
            return self._overhang()
        if name == CELL_QUALITY:
            return _measured(self._finer) / self._all.measured
        faces = self._all.facing[name]
        if not len(faces.corners):
            return np.empty(0)
        return faces.distances(self._corners(faces.corners)).ravel()

    def row_gradients(self, name: str, chosen: Ints) -> Floats:
        """Derivatives (variables, chosen) of some of them."""
        if not len(chosen):
            return np.empty((len(self._all.variables), 0))
        if name == OVERHANG:
            return self._overhang_slopes(chosen)
        if name == CELL_QUALITY:
            return self._quality_slopes(chosen)
        faces = self._all.facing[name]
        pairs, inverse = np.unique(chosen // 4, return_inverse=True)
        here = Facing(faces.corners[pairs])
        flat = self._on_planes(here.corners.reshape(-1, 3))
        velocity = self._slopes(flat).reshape(-1, len(pairs), 2, 4, 3)
        slopes = here.slopes(placed(flat, self.config).reshape(-1, 2, 4, 3), velocity)
        return np.asarray(slopes[:, inverse, chosen % 4])

    def _corners(self, corners: Floats) -> Floats:
        flat = self._on_planes(corners.reshape(-1, 3))
        return placed(flat, self.config).reshape(corners.shape)

    def _quality_slopes(self, chosen: Ints) -> Floats:
        count = self._all.corners
        of_edge = chosen >= count
        corner = np.where(of_edge, (chosen - count) // 3, chosen)
        nodes, edges, length = _edges(self._finer, corner)
        unit = edges / length[..., None]
        # the cofactor of each edge, less what makes that edge longer alone
        across = np.stack(
            [np.cross(unit[:, (i + 1) % 3], unit[:, (i + 2) % 3]) for i in range(3)], axis=1
        )
        jacobian = np.linalg.det(unit)[:, None, None]
        by_edge = (across - jacobian * unit) / length[..., None]
        one_hot = np.arange(3) == ((chosen - count) % 3)[:, None]
        by_edge = np.where(of_edge[:, None, None], one_hot[..., None] * unit, by_edge)
        used, at = np.unique(nodes, return_inverse=True)
        velocity = self._slopes(self._on_planes(self._all.finer.points[used]))
        at = at.reshape(nodes.shape)
        moving = velocity[:, at[:, 1:]] - velocity[:, at[:, :1]]
        slopes = np.einsum("pkei,kei->pk", moving, by_edge)
        return np.asarray(slopes / self._all.measured[chosen])

    def _overhang(self) -> Floats:
        """Angle (deg) of each facet from the vertical, printed along z; 0 if it faces up."""
        normal = np.cross(*_diagonals(self.mesh.points[self._all.printed]))
        down = -normal[:, 2] / np.linalg.norm(normal, axis=1)
        return np.degrees(np.arcsin(np.clip(down, 0.0, 1.0)))

    def _overhang_slopes(self, chosen: Ints) -> Floats:
        facets = self._all.printed[chosen]
        first, second = _diagonals(self.mesh.points[facets])
        along, across = _diagonals(self._velocity[:, facets])
        normal = np.cross(first, second)
        length = np.linalg.norm(normal, axis=1)
        unit = normal / length[:, None]
        turning = np.cross(along, second) + np.cross(first, across)
        down = turning[..., 2] - unit[:, 2] * np.einsum("pki,ki->pk", turning, unit)
        cosine = np.sqrt(np.clip(1 - unit[:, 2] ** 2, 1e-12, None))
        return np.asarray(np.degrees(-down / length / cosine))
