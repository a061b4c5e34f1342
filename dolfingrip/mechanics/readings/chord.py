"""The angle of a line between two places on a model, seen from the side by a camera."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.readings.reading import Reading
from dolfingrip.mechanics.readings.tip import angle_deg, angle_slopes

LEVEL = 1e-6
"""A node lies on an edge if its distance, relative to the model's extent, is smaller than this."""

NEAR = 0.05
"""A point is the nearest node if their distance, relative to the extent, is smaller than this."""


class LineAngle(Reading):
    """Rotation about y of the line between two weighted means of nodes (deg), towards −x.

    Args:
        model: model that is read.
        column: name in the table, with the unit.
        start, end: (n,) weights of this rank's owned displacement nodes, of sum 1 on all ranks.
    """

    def __init__(self, model: Model, column: str, start: np.ndarray, end: np.ndarray) -> None:
        super().__init__(model, column)
        self._weights = end - start

    def _arm(self) -> np.ndarray:
        """From the line's start to its end (mm), (3,)."""
        u = self.model.u
        now = u.function_space.tabulate_dof_coordinates() + u.x.array.reshape(-1, 3)
        return self._summed(now)

    def _summed(self, nodal: np.ndarray) -> np.ndarray:
        local = self._weights @ nodal[: len(self._weights)]
        return np.asarray(self.model.comm.allreduce(local, MPI.SUM))

    def value(self) -> float:
        x, _, z = self._arm()
        return angle_deg(x, z)

    def add_gradient(self, gradient: Gradient) -> None:
        gradient.at_nodes[:, [0, 2]] += self._slopes()

    def _slopes(self) -> np.ndarray:
        """Derivatives by x and z of this rank's owned nodes, at rest or displaced, (n, 2)."""
        x, _, z = self._arm()
        return np.asarray(self._weights[:, None] * angle_slopes(x, z))

    def add_shape_gradient(self, gradient: ShapeGradient) -> None:
        gradient.at_nodes[: len(self._weights), [0, 2]] += self._slopes()


def edge(model: Model, where: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Weights of the nodes in the mean of a piecewise linear function over an edge along y.

    Args:
        model: model with nodes on the edge.
        where: returns distances (n,) from the edge (mm) at (n, 3) coordinates.
    """
    nodes = model.nodes_mm
    on_edge = np.flatnonzero(where(nodes) <= LEVEL * _extent(model))
    every = model.comm.allgather(nodes[on_edge, 1])
    order = np.argsort(np.concatenate(every), kind="stable")
    along = np.concatenate(every)[order]
    widths = np.diff(along)
    shares = np.zeros(len(along))
    if len(widths):
        shares[order[:-1]] += widths / 2
        shares[order[1:]] += widths / 2
    else:
        shares[:] = 1.0
    first = sum(len(part) for part in every[: model.comm.rank])
    weights = np.zeros(len(nodes))
    weights[on_edge] = shares[first : first + len(on_edge)] / shares.sum()
    return weights


def back_edge(model: Model, region: str) -> np.ndarray:
    """Weights of the edge that a region at one end and the back, at the lowest x, have in common.

    If a region extends along z, such as a cup, it is the edge nearer to the middle.

    Args:
        model: model that is read.
        region: name of a region of the boundary at one end.

    Returns:
        Weights of this rank's displacement nodes, which add up to 1 on all ranks.
    """
    nodes = model.nodes_mm
    space = model.u.function_space
    box = model.box_mm
    lowest, middle = box[0, 0], box[:, 2].mean()
    inside = fem.locate_dofs_topological(space, 2, model.domain.facets(region))
    inside = inside[inside < len(nodes)]
    back = nodes[inside]
    z = back[back[:, 0] <= lowest + LEVEL * _extent(model), 2]
    nearest = model.comm.allgather(z[np.abs(z - middle).argmin()] if len(z) else np.inf)
    level = min(nearest, key=lambda z: abs(z - middle))
    return edge(model, lambda x: np.hypot(x[:, 0] - lowest, x[:, 2] - level))


def point(model: Model, at: np.ndarray) -> np.ndarray | None:
    """Weights of the node nearest to a point.

    Args:
        model: model that is read.
        at: (3,) the point (mm).

    Returns:
        Weights of this rank's displacement nodes, which add up to 1 on all ranks; None if
        no node is near.
    """
    nodes = model.nodes_mm
    distance = np.linalg.norm(nodes - at, axis=1)
    least = model.comm.allgather(float(distance.min(initial=np.inf)))
    if min(least) > NEAR * _extent(model):
        return None
    weights = np.zeros(len(nodes))
    if int(np.argmin(least)) == model.comm.rank:
        weights[distance.argmin()] = 1.0
    return weights


def _extent(model: Model) -> float:
    return float(np.ptp(model.box_mm[:, 2]))
