"""Shapes of the solid's elements: their corners, edges and faces, in Gmsh's order."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CellShape:
    """An element's shape, of first order or, with a node amid each edge, of second.

    Attributes
    ----------
    name, facet_name
        Of the element and of its faces, as basix has them.
    corners, facet_corners
        Number of corners.
    edges
        Corners of each edge, shape (e, 2); the node amid edge ``i`` is ``corners + i``.
    faces
        Local nodes of each face, shape (f, 2 · facet_corners): the corners
        counter-clockwise seen from outside, then the nodes amid the edges from each corner to
        the next. The order of the faces is Abaqus' (S1, S2, …).
    """

    name: str
    facet_name: str
    edges: Ints
    face_corners: Ints
    faces: Ints = field(init=False)

    def __post_init__(self) -> None:
        amid = {frozenset(edge): self.corners + i for i, edge in enumerate(self.edges.tolist())}
        following = np.roll(self.face_corners, -1, axis=1)
        middles = [
            [amid[frozenset(pair)] for pair in zip(face, then, strict=True)]
            for face, then in zip(self.face_corners.tolist(), following.tolist(), strict=True)
        ]
        object.__setattr__(self, "faces", np.hstack([self.face_corners, middles]))

    @property
    def corners(self) -> int:
        """Number of the element's corners."""
        return int(self.edges.max()) + 1

    @property
    def facet_corners(self) -> int:
        """Number of a face's corners."""
        return int(self.face_corners.shape[1])

    def order(self, nodes: int) -> int:
        """Order of an element with so many nodes, 1 or 2."""
        return 1 if nodes == self.corners else 2


TETRAHEDRON: Final = CellShape(
    "tetrahedron",
    "triangle",
    np.array([[0, 1], [1, 2], [0, 2], [0, 3], [2, 3], [1, 3]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
)

HEXAHEDRON: Final = CellShape(
    "hexahedron",
    "quadrilateral",
    np.array(
        [[0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3]]
        + [[2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]]
    ),
    np.array(
        [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4]] + [[1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    ),
)

BY_NODES: Final = {4: TETRAHEDRON, 10: TETRAHEDRON, 8: HEXAHEDRON, 20: HEXAHEDRON}
"""The shape of an element, by its number of nodes."""

FACET_CORNERS: Final = {3: 3, 6: 3, 4: 4, 8: 4}
"""Corners of a facet, by its number of nodes."""
