"""Deformable surfaces of linear triangles, which every rank knows as a whole."""

from __future__ import annotations

import math
from copy import copy
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.contact.node_set import NodeSet
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.meshes import cells

# A quadratic triangle's nodes are its corners, then the midpoints opposite to them; those of a
# quadrilateral its corners in turn, then the midpoints from each to the next.
SPLIT = {
    3: np.array([[0, 1, 2]]),
    4: np.array([[0, 1, 2], [0, 2, 3]]),
    6: np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2], [3, 4, 5]]),
    8: np.array([[0, 4, 7], [1, 5, 4], [2, 6, 5], [3, 7, 6], [4, 5, 7], [5, 6, 7]]),
}

IN_TURN = {4: [0, 1, 3, 2], 8: [0, 1, 3, 2, 4, 6, 7, 5]}
"""Nodes of a facet in turn, from a tensor product's order with edges 01, 02, 13 and 23."""


class Surface(NodeSet):
    """Triangulated surface of a body, whose vertices move with the displacement nodes.

    On tetrahedra the vertices are the nodes, and each quadratic facet becomes four triangles. On
    hexahedra in the planes of a grid they are spread evenly (:mod:`.surface`). All ranks hold
    equal arrays, so that each finds the same contact. A rank contributes the rows of the nodes that
    it owns.

    Args:
        space: of the displacement.
        domain: reference configuration.
        facets: this rank's facets of the surface.
        spacing_mm: largest distance of neighbouring vertices that are spread evenly; None: the
            nodes are the vertices.

    Attributes:
        rest: (v, 3) positions of the vertices at rest in the world (mm).
        triangles: (m, 3) vertex numbers.
        nodes: (n,) global displacement nodes (block index) that the vertices move with.
        owned: places in ``nodes`` of the nodes that this rank owns.
        weights: (v, n) weights of the nodes in each vertex; rows sum to 1.
        spread: (3v, 3n) from displacements of the nodes to those of the vertices.
    """

    def __init__(
        self,
        space: fem.FunctionSpace,
        domain: Domain,
        facets: np.ndarray,
        spacing_mm: float | None = 2.5,
    ) -> None:
        local = _facet_nodes(space, domain, facets)
        global_nodes = space.dofmap.index_map.local_to_global(local.ravel().astype(np.int32))
        gathered = space.mesh.comm.allgather(global_nodes.reshape(local.shape))
        width = max(block.shape[1] for block in gathered)
        nodes, faces = np.unique(
            np.concatenate([b.reshape(-1, width) for b in gathered]), return_inverse=True
        )
        super().__init__(space, nodes)
        rest_mm = self.at_nodes(space.tabulate_dof_coordinates()[: self._end - self._first])
        # ipctk's collision sets depend on the order of vertices and triangles, which must not
        # depend on the ranks': sort by position, not by owner
        order = _by_position(rest_mm)
        rank_of = np.empty_like(order)
        rank_of[order] = np.arange(len(order))
        rest_mm = rest_mm[order]
        self._number(nodes[order])
        faces = _canonical(rank_of[faces].reshape(-1, width))
        spread = resample(faces, rest_mm, spacing_mm) if width == 8 and spacing_mm else None
        if spread is None:
            self.weights = sp.eye_array(len(rest_mm), format="csr")
            self.triangles: np.ndarray = faces[:, SPLIT[width]].reshape(-1, 3).astype(np.int32)
        else:
            self.weights = spread[0]
            self.triangles = spread[1].astype(np.int32)
        if domain.placement is not None:
            self.frames = domain.placement.frames(rest_mm)
            rest_mm = domain.placement.positions(rest_mm)
        self.rest = self.weights @ rest_mm
        self.spread = sp.kron(self.weights, sp.eye_array(3), format="csr")

    def mirrored(self) -> Surface:
        """This surface with its image in the plane y = 0, joined where both meet."""
        image = np.array([1.0, -1.0, 1.0])
        apart = np.flatnonzero(np.abs(self.rest[:, 1]) > NEAR * np.ptp(self.rest, axis=0).max())
        number = np.arange(len(self.rest), dtype=np.int32)
        number[apart] = len(self.rest) + np.arange(len(apart))
        other = copy(self)
        other.rest = np.asfortranarray(np.concatenate([self.rest, self.rest[apart] * image]))
        image_of = number[self.triangles][:, ::-1]
        other.triangles = np.concatenate([self.triangles, image_of], dtype=np.int32)
        other.weights = sp.vstack([self.weights, self.weights[apart]], format="csr")
        turned = sp.kron(self.weights[apart], sp.diags_array(image))
        other.spread = sp.vstack([self.spread, turned], format="csr")
        return other

    def moved(self, change_mm: np.ndarray) -> Surface:
        """This surface with its reference positions moved by ``change_mm``, (v, 3)."""
        other = copy(self)
        other.rest = np.asfortranarray(self.rest + change_mm)
        return other

    def displacement(self, local_dofs: np.ndarray) -> np.ndarray:
        """Displacement (mm) of the vertices from a local dof array, (v, 3)."""
        return np.asarray(self.spread @ self.at_nodes(local_dofs).ravel()).reshape(-1, 3)

    def gathered(self, at_vertices: np.ndarray) -> np.ndarray:
        """Derivatives by the nodes' displacements from those (v, 3) by the vertices', (n, 3)."""
        return np.asarray(self.spread.T @ at_vertices.ravel()).reshape(-1, 3)

    def positions(self, local_dofs: np.ndarray) -> np.ndarray:
        """Deformed positions (mm), in the column order that ipctk wants, (v, 3)."""
        return np.asfortranarray(self.rest + self.displacement(local_dofs))

    @property
    def interpolated(self) -> bool:
        """Return whether some vertices lie between nodes."""
        return bool(self.weights.nnz > len(self.rest))

    @property
    def edges(self) -> np.ndarray:
        """Unique edges of the triangles, (k, 2)."""
        pairs = np.concatenate(
            [self.triangles[:, [0, 1]], self.triangles[:, [1, 2]], self.triangles[:, [2, 0]]]
        )
        return np.unique(np.sort(pairs, axis=1), axis=0).astype(np.int32)


def _by_position(points: np.ndarray) -> np.ndarray:
    """Order of points by z, y, x, (n,); rounding does not change it."""
    # an irrational shift keeps round positions off the borders between two roundings
    keys = np.floor(points / (1e-7 * np.ptp(points, axis=0).max()) + 0.2360679775)
    return np.lexsort(keys.T)


def _canonical(facets: np.ndarray) -> np.ndarray:
    """Facets that start at their smallest corner and run on to its smaller neighbour, sorted."""
    corners = 3 if facets.shape[1] in (3, 6) else 4
    facets = _turned(facets, corners)
    return facets[np.lexsort(facets[:, corners - 1 :: -1].T)]


def _turned(facets: np.ndarray, corners: int) -> np.ndarray:
    if corners == 3:  # its midpoints are opposite to the corners, so they move with them
        turn = np.argsort(facets[:, :3], axis=1)
        parts = [facets[:, i : i + 3] for i in range(0, facets.shape[1], 3)]
        return np.concatenate([np.take_along_axis(p, turn, axis=1) for p in parts], axis=1)
    turn = (facets[:, :4].argmin(axis=1)[:, None] + np.arange(4)) % 4
    parts = [
        np.take_along_axis(facets[:, i : i + 4], turn, axis=1) for i in range(0, facets.shape[1], 4)
    ]
    back = parts[0][:, 3] < parts[0][:, 1]
    parts[0][back] = parts[0][back][:, [0, 3, 2, 1]]
    for middles in parts[1:]:
        middles[back] = middles[back][:, ::-1]
    return np.concatenate(parts, axis=1)


def _facet_nodes(space: fem.FunctionSpace, domain: Domain, facets: np.ndarray) -> np.ndarray:
    """Local displacement nodes of each facet, (n, nodes): corners, then midpoints."""
    topology = domain.mesh.topology
    to_cell = topology.connectivity(2, 3)
    topology.create_connectivity(3, 2)
    to_facet = topology.connectivity(3, 2)
    closure = [np.array(dofs) for dofs in space.element.basix_element.entity_closure_dofs[2]]
    nodes = np.empty((len(facets), len(closure[0])), dtype=np.int32)
    for row, facet in enumerate(facets):
        cell = to_cell.links(facet)[0]
        which = int(np.flatnonzero(to_facet.links(cell) == facet)[0])
        nodes[row] = space.dofmap.cell_dofs(cell)[closure[which]]
    return nodes[:, IN_TURN[nodes.shape[1]]] if nodes.shape[1] in IN_TURN else nodes


NEAR = 1e-6
"""Part of the body's extent below which coordinates count as equal."""


def resample(
    facets: np.ndarray, rest_mm: np.ndarray, spacing_mm: float
) -> tuple[sp.csr_matrix, np.ndarray] | None:
    """Points at the corners of rectangles of about ``spacing_mm``, and triangles between them.

    A structured mesh is graded by planes that run through the whole body. Some facets of its skin
    are therefore narrower than the barrier's reach, and others are wide. Contact needs points whose
    density follows from the contact zones. A point inside a facet moves with the facet's shape
    functions.

    Args:
        facets: (m, 8) nodes of quadrilaterals, corners in turn, then the midpoints from each
            to the next.
        rest_mm: (n, 3) reference positions of the nodes (mm).
        spacing_mm: longest edge of a rectangle; except at walls, the shortest is half of it.

    Returns:
        (v, n) weights of the nodes in each point's position and displacement, and (k, 3) points
        of each triangle; None if the facets do not lie in the planes of a rectilinear grid.
    """
    corners = rest_mm[facets[:, :4]]
    low, high = corners.min(axis=1), corners.max(axis=1)
    near = NEAR * np.ptp(rest_mm, axis=0).max()
    flat = high - low < near
    on_low = np.abs(corners - low[:, None]) < near
    aligned = on_low | (np.abs(corners - high[:, None]) < near)
    if not (flat.sum(axis=1) == 1).all() or not aligned.all():
        return None
    normal = flat.argmax(axis=1)
    lines = [
        _lines(low[normal == axis, axis], rest_mm[:, axis], spacing_mm, near) for axis in range(3)
    ]
    points, rectangles = _rectangles(low, high, normal, lines, near)
    weights = _weights(points, facets, rest_mm, low, high, near)
    # diagonals alternate, so that no direction is preferred
    return weights, rectangles[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)


def _lines(walls: np.ndarray, planes: np.ndarray, spacing: float, near: float) -> np.ndarray:
    """Coordinates of the samples along one axis: walls, and points fixed in the cells between.

    A share of its cell is what a sample keeps when the mesh is morphed, so that it stays the same
    point of the material. Samples that would come nearer than half the spacing are left out.
    """
    planes, fixed = _distinct(planes, near), _distinct(walls, near)
    fixed = _distinct(np.concatenate([fixed, planes[[0, -1]]]), near)
    candidates = np.concatenate(
        [np.linspace(a, b, math.ceil((b - a) / spacing) + 1)[:-1] for a, b in pairwise(planes)]
        + [planes[-1:]]
    )
    kept = [candidates[0]]
    for value in candidates[1:]:
        following = fixed[fixed > value - near][0]
        wall = following - value < near
        if wall or min(value - kept[-1], following - value) > (1 - NEAR) * spacing / 2:
            kept.append(value)
    return np.array(kept)


def _distinct(values: np.ndarray, near: float) -> np.ndarray:
    """Sorted values; values nearer than ``near`` become one."""
    values = np.sort(values)
    return values[np.concatenate([[True], np.diff(values) > near])]


def _rectangles(
    low: np.ndarray, high: np.ndarray, normal: np.ndarray, lines: list[np.ndarray], near: float
) -> tuple[np.ndarray, np.ndarray]:
    """Points (v, 3), and points (r, 4) of each rectangle, in turn from alternating corners."""
    covered: list[tuple[int, int, int, int]] = []
    for a, b, axis in zip(low, high, normal, strict=True):
        first, second = [i for i in range(3) if i != axis]
        level = int(np.abs(lines[axis] - a[axis]).argmin())
        inside = []
        for i in (first, second):
            centre = (lines[i][1:] + lines[i][:-1]) / 2
            inside.append(np.flatnonzero((centre > a[i] - near) & (centre < b[i] + near)))
        covered += [(int(axis), level, int(i), int(j)) for i in inside[0] for j in inside[1]]
    cells = np.unique(np.array(covered), axis=0)  # a centre on an edge belongs to two facets
    turn = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    index = np.empty((len(cells), 4, 3), dtype=np.int64)
    for axis in range(3):
        part = cells[:, 0] == axis
        first, second = [i for i in range(3) if i != axis]
        index[part, :, axis] = cells[part, 1, None]
        index[part, :, first] = cells[part, 2, None] + turn[:, 0]
        index[part, :, second] = cells[part, 3, None] + turn[:, 1]
    odd = cells[:, 1:].sum(axis=1) % 2 == 1
    index[odd] = np.roll(index[odd], 1, axis=1)
    unique, number = np.unique(index.reshape(-1, 3), axis=0, return_inverse=True)
    points = np.column_stack([lines[axis][unique[:, axis]] for axis in range(3)])
    return points, number.reshape(-1, 4)


def _weights(
    points: np.ndarray,
    facets: np.ndarray,
    rest_mm: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    near: float,
) -> sp.csr_matrix:
    """Shape functions of a facet that holds each point, at the point, (v, n)."""
    functions = cells.of_facet(facets.shape[1])
    rows, columns, values = [], [], []
    for i, point in enumerate(points):
        facet = int(((point > low - near) & (point < high + near)).all(axis=1).argmax())
        origin, first, _, last = rest_mm[facets[facet, :4]]
        edges = np.array([first - origin, last - origin])
        local = (edges @ (point - origin)) / (edges**2).sum(axis=1)
        weight = functions.values(local[None])[0]
        weight[np.abs(weight) < NEAR] = 0.0
        rows += [i] * len(weight)
        columns += facets[facet].tolist()
        values += weight.tolist()
    weights = sp.csr_matrix((values, (rows, columns)), shape=(len(points), len(rest_mm)))
    weights.eliminate_zeros()
    return weights
