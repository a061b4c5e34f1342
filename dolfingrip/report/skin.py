"""The finger's surface: boundary facets of the elements, their edges, and the mirrored half.

It is found once on the reference mesh. A displacement only moves its nodes, so edges and
creases stay the same from picture to picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
import numpy.typing as npt

from dolfingrip.meshes.cells import BY_NODES
from dolfingrip.meshes.solid import boundary, faces
from dolfingrip.report.fields import FieldMesh

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# The triangles of a facet, by its number of nodes; the ninth is the quadrilateral's middle.
_PARTS: Final = {
    3: [(0, 1, 2)],
    6: [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)],
    4: [(0, 1, 2), (0, 2, 3)],
    8: [(0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7)],
    9: [
        *((0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8)),
        *((2, 6, 8), (6, 3, 8), (3, 7, 8), (7, 0, 8)),
    ],
}


CREASE_DEG: Final = 35.0
"""Angle between facets of the undeformed mesh from which their edge is a crease."""


NO_SEGMENTS: Final[Ints] = np.zeros((0, 2), dtype=np.int64)


@dataclass(frozen=True)
class Skin:
    """A triangulated surface whose points are nodes of the mesh or their mirror images.

    Attributes:
        points: reference positions in mm, shape (points, 3).
        node: node of the mesh behind each point, shape (points,).
        side: +1, or −1 where the point is the mirror image in y = 0, shape (points,).
        triangles: shape (triangles, 3), seen from outside anticlockwise; several for each facet.
        edges: segments of the facets' edges, shape (segments, 2).
        creases: segments of edges where the surface folds or ends, shape (segments, 2).
    """

    points: Floats
    node: Ints
    side: Floats
    triangles: Ints
    edges: Ints
    creases: Ints

    @classmethod
    def plain(cls, points: Floats, triangles: Ints, creases: Ints = NO_SEGMENTS) -> Self:
        """A surface that is none of a mesh, without edges of facets."""
        count = len(points)
        return cls(points, np.arange(count), np.ones(count), triangles, NO_SEGMENTS, creases)

    def move(self, displacement: Floats) -> Floats:
        """Positions in mm, shape (points, 3), for nodal displacements in mm, shape (nodes, 3)."""
        moved = displacement[self.node].copy()
        moved[:, 1] *= self.side
        return self.points + moved

    def on_walls(self, values: Floats, plane_mm: float) -> Floats:
        """Values at the triangles of chamber walls, and 0 at all others, those of a cut included.

        Args:
            values: at the points, 0 where a point lies on no wall, shape (points,).
            plane_mm: y of the plane of cuts.

        Returns:
            Shape (triangles,).
        """
        corners = self.points[self.triangles, 1]
        small = 1e-6 * float(np.ptp(self.points, axis=0).max())
        at, cut = values[self.triangles], (np.abs(corners - plane_mm) < small).all(axis=1)
        return np.asarray(np.where((at != 0).all(axis=1) & ~cut, at[:, 0], 0.0))

    def part(self, mine: npt.NDArray[np.bool_]) -> Skin:
        """The part of the surface that some points alone make up; ``mine`` has shape (points,)."""
        number = np.cumsum(mine) - 1

        def kept(items: Ints) -> Ints:
            return number[items[mine[items].all(axis=1)]]

        return Skin(
            self.points[mine], self.node[mine], self.side[mine],
            kept(self.triangles), kept(self.edges), kept(self.creases),
        )  # fmt: skip


def mid_plane(points: Floats) -> float:
    """Find y (mm) of the plane that a finger is cut open in: of half a finger that of symmetry.

    Args:
        points: of the finger at rest, shape (points, 3).
    """
    low, high = float(points[:, 1].min()), float(points[:, 1].max())
    return low if low > -1e-6 * float(np.ptp(points, axis=0).max()) else (low + high) / 2


def extract_skin(mesh: FieldMesh, mirror: bool = True, cut: bool = False) -> Skin:
    """Surface of a finger.

    Args:
        mesh: whole finger, or its half y ≥ 0.
        mirror: complete a half finger with its mirror image in y = 0, without the facets in that
            plane; a whole one is left as it is.
        cut: take the facets in the symmetry plane y = 0 and no others: the section of a half
            finger, its cavity left open. ``mirror`` is then without effect.

    Raises:
        ValueError: One line where a cut is asked of a whole finger.
    """
    size = float(np.ptp(mesh.points, axis=0).max())
    half = bool(mesh.points[:, 1].min() > -1e-6 * size)
    if cut and not half:
        raise ValueError("mesh.half = false: a section is drawn of the half finger only")
    facets = _boundary(mesh)
    corners = _corners(facets)
    if half and (mirror or cut):
        in_plane = (np.abs(mesh.points[facets[:, :corners], 1]) < 1e-6 * size).all(axis=1)
        facets = facets[in_plane == cut]
    node, numbered = np.unique(facets, return_inverse=True)
    facets = numbered.reshape(facets.shape).astype(np.int64)
    points = mesh.points[node]
    side: Floats = np.ones(len(node))
    if half and mirror and not cut:
        points, node, side, facets = _mirror(points, node, facets, 1e-6 * size)
    triangles = np.concatenate([facets[:, part] for part in _PARTS[facets.shape[1]]])
    edges, creases = _edges(points, facets)
    return Skin(points, node, side, triangles, edges, creases)


def _boundary(mesh: FieldMesh) -> Ints:
    """Facets that belong to one element only, corners first, seen from outside."""
    simple = mesh.cells[:, :20]
    rows = boundary(simple)
    facets = faces(simple)[rows]
    shape = BY_NODES[simple.shape[1]]
    cell, face = np.divmod(rows, len(shape.faces))
    if mesh.cells.shape[1] > simple.shape[1]:
        facets = np.column_stack([facets, mesh.cells[cell, simple.shape[1] + face]])
    # Elements come in either handedness, so their middle decides which side is outside.
    middle = mesh.points[mesh.cells[:, : shape.corners]].mean(axis=1)[cell]
    way_in = middle - mesh.points[facets[:, 0]]
    inward = np.einsum("ij,ij->i", _normals(mesh.points, facets), way_in) > 0
    facets[inward] = _flip(facets[inward])
    return facets


def _corners(facets: Ints) -> int:
    """How many of a facet's nodes are corners."""
    return 3 if facets.shape[1] in (3, 6) else 4


def _mirror(
    points: Floats, node: Ints, facets: Ints, tolerance: float
) -> tuple[Floats, Ints, Floats, Ints]:
    """The surface and its image in y = 0; both share the points that lie in that plane."""
    off = np.flatnonzero(np.abs(points[:, 1]) > tolerance)
    image = np.arange(len(points))
    image[off] = len(points) + np.arange(len(off))
    side = np.concatenate([np.ones(len(points)), -np.ones(len(off))])
    both = np.concatenate([points, points[off] * [1.0, -1.0, 1.0]])
    return (
        both,
        np.concatenate([node, node[off]]),
        side,
        np.concatenate([facets, _flip(image[facets])]),
    )


def _flip(facets: Ints) -> Ints:
    """The facets with their nodes in the order seen from the other side."""
    corners, nodes = _corners(facets), facets.shape[1]
    order = [0, *range(corners - 1, 0, -1)]
    if nodes > corners:
        order += [*range(2 * corners - 1, corners - 1, -1), *range(2 * corners, nodes)]
    return facets[:, order]


def _normals(points: Floats, facets: Ints) -> Floats:
    """Normals of triangles, or of quadrilaterals by their diagonals, shape (facets, 3)."""
    a, b, c, d = (points[facets[:, i]] for i in (0, 1, 2, _corners(facets) - 1))
    return np.asarray(np.cross(c - a, d - b))


def _edges(points: Floats, facets: Ints) -> tuple[Ints, Ints]:
    """Segments of all edges, and of those where neighbouring facets fold or one is missing."""
    normals = _normals(points, facets)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    corners = _corners(facets)
    ends = np.concatenate([facets[:, [i, (i + 1) % corners]] for i in range(corners)])
    owner = np.tile(np.arange(len(facets)), corners)
    _, first, inverse, count = np.unique(
        np.sort(ends, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    inverse = inverse.reshape(-1)
    order = np.argsort(inverse, kind="stable")
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    one, other = owner[order[start]], owner[order[start + count - 1]]
    fold = np.einsum("ij,ij->i", normals[one], normals[other])
    sharp = (count != 2) | (fold < np.cos(np.radians(CREASE_DEG)))
    if facets.shape[1] == corners:
        segments = ends[first][:, None, :]
    else:
        middle = np.concatenate([facets[:, corners + i] for i in range(corners)])[first]
        a, b = ends[first].T
        segments = np.stack([np.stack([a, middle], 1), np.stack([middle, b], 1)], axis=1)
    return segments.reshape(-1, 2), segments[sharp].reshape(-1, 2)
