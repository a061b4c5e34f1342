"""A closed surface of triangles in faces: its edges, its faces' outlines, its parts."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from dolfingrip.meshes.solid import Floats, Ints, parts_of


@dataclass(frozen=True, slots=True)
class FacePolicy:
    """How faces and openings are recognised, and taken for clamp, tip and sides.

    Attributes:
        flat_deg: angle between neighbouring triangles, and from a face's mean, up to which a face
            is plane.
        crease_deg: angle between neighbouring triangles from which they are two faces.
        wider: width of a plane face, by that of what follows it without a crease.
        near: distance, relative to a part's extent, up to which points lie in one plane.
        rim: length of an opening's rim on a curved face, by that of the face's longest edge.
        convex: share of a rim's length that must be a convex edge.
        directions: ways in which the outermost points are sought, which tell out from in.
        faces: area vector of a clamp by its area, above which it faces one way.
        end_deg: angle between an end's face and the long axis's normal plane.
        mouth: area of an opening by the smallest one's of the same hollow, from which it is no air
            supply but a cup's mouth.
        supplied: weight of an end's face into which air can be led.
        alike_area: relative difference up to which two ends' faces are as large.
        tip_share: part of the length at the free end that is the tip where no face ends it.
        lines: lines along the part, across its widest side, along which its walls are read.
        ends: share of the cavity's length at either end that these lines leave out.
        bearing: power of a line's share in the solid that weights what the line bears.
        same_side: lever of the pressure about the walls, by the width across, from which it tells
            the side that bends outwards.
        snap_deg: angle within which that side is taken along an axis of the file or of inertia.
        even: distance of a mirror image, relative to the extent, up to which a part is symmetric.
        small: volume of a hollow, by the largest's, below which it is not taken for a cavity.
        alike: the same of hollows with openings.
    """

    flat_deg: float = 0.5
    crease_deg: float = 30.0
    wider: float = 3.0
    near: float = 1e-3
    rim: float = 0.5
    convex: float = 0.9
    directions: int = 500
    faces: float = 0.1
    end_deg: float = 25.0
    mouth: float = 2.0
    supplied: float = 1.5
    alike_area: float = 1e-3
    tip_share: float = 0.05
    lines: int = 150
    ends: float = 0.05
    bearing: float = 100.0
    same_side: float = 0.005
    snap_deg: float = 10.0
    even: float = 1e-3
    small: float = 0.02
    alike: float = 0.5


@dataclass(eq=False)
class Faces:
    """Triangles that belong to faces.

    Attributes:
        points: (n, 3), mm.
        triangles: (m, 3), counter-clockwise seen from outside of the solid.
        face: (m,) number of each triangle's face, from 0 on.
        policy: how faces are recognised.
    """

    points: Floats
    triangles: Ints
    face: Ints
    policy: FacePolicy = field(default_factory=FacePolicy)

    @cached_property
    def vectors(self) -> Floats:
        """Area vectors, out of the solid (mm²), (m, 3)."""
        a, b, c = (self.points[self.triangles[:, i]] for i in range(3))
        return np.asarray(np.cross(b - a, c - a) / 2)

    @cached_property
    def areas(self) -> Floats:
        """Areas (mm²), (m,)."""
        return np.asarray(np.linalg.norm(self.vectors, axis=1))

    @cached_property
    def normals(self) -> Floats:
        """Unit normals out of the solid, (m, 3)."""
        return self.vectors / np.maximum(self.areas, 1e-300)[:, None]

    @cached_property
    def middles(self) -> Floats:
        """Centres (mm), (m, 3)."""
        return np.asarray(self.points[self.triangles].mean(axis=1))

    @cached_property
    def extent(self) -> float:
        """Longest side of the box around it (mm)."""
        return float(np.ptp(self.points[self.triangles], axis=(0, 1)).max())

    @property
    def near_mm(self) -> float:
        """Distance up to which points lie in one plane."""
        return self.policy.near * self.extent

    @cached_property
    def volumes(self) -> Floats:
        """Signed volumes of tetrahedra from the origin to each triangle (mm³), (m,)."""
        return np.asarray(np.einsum("ij,ij->i", self.middles, self.vectors) / 3)

    @cached_property
    def pairs(self) -> tuple[Ints, Ints]:
        """Triangles (k, 2) at each edge, and (k, 2) the edge's points as the first one turns."""
        return pairs(self.triangles)

    @cached_property
    def face_vectors(self) -> Floats:
        """Area vectors of the faces (mm²), (f, 3)."""
        vectors = np.zeros((int(self.face.max()) + 1, 3))
        np.add.at(vectors, self.face, self.vectors)
        return vectors

    @cached_property
    def face_areas(self) -> Floats:
        """Areas of the faces (mm²), (f,)."""
        return np.asarray(np.bincount(self.face, self.areas), dtype=float)

    @cached_property
    def plane(self) -> np.ndarray:
        """Mask, (f,): whether each face is plane."""
        length = np.linalg.norm(self.face_vectors, axis=1)
        mean = self.face_vectors / np.maximum(length, 1e-300)[:, None]
        cosine = np.einsum("ij,ij->i", self.normals, mean[self.face])
        off = np.where(self.areas > 1e-12 * self.areas.max(), cosine, 1.0)
        least = np.full(len(length), 1.0)
        np.minimum.at(least, self.face, off)
        return np.asarray(least > np.cos(np.radians(2 * self.policy.flat_deg)))

    def components(self, joined: np.ndarray | None = None) -> Ints:
        """Number of the connected part of each triangle, (m,).

        Args:
            joined: (k,) edges of ``pairs`` that connect; all where None.
        """
        at = self.pairs[0] if joined is None else self.pairs[0][joined]
        return parts_of(at, len(self.triangles))

    def moved(self, rotation: Floats, origin: Floats) -> Faces:
        """This surface at R (x − o)."""
        return replace(self, points=(self.points - origin) @ rotation.T)


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A closed line on the border of a face.

    Attributes:
        face: number of the face.
        edges: rows of the surface's ``pairs``.
        ends: (k, 2) points of each edge, as the face's triangles turn.
        beyond: (k,) triangles on the other side.
    """

    face: int
    edges: Ints
    ends: Ints
    beyond: Ints

    def length_mm(self, surface: Faces) -> float:
        """Length of the line."""
        a, b = (surface.points[self.ends[:, i]] for i in (0, 1))
        return float(np.linalg.norm(b - a, axis=1).sum())

    def centre_mm(self, surface: Faces) -> Floats:
        """Mean of the line, (3,)."""
        a, b = (surface.points[self.ends[:, i]] for i in (0, 1))
        weights = np.linalg.norm(b - a, axis=1)
        return np.asarray(np.average((a + b) / 2, axis=0, weights=weights))

    def vector_mm2(self, surface: Faces) -> Floats:
        """Area vector that the line encloses, (3,)."""
        a, b = (surface.points[self.ends[:, i]] - self.centre_mm(surface) for i in (0, 1))
        return np.asarray(np.cross(a, b).sum(axis=0) / 2)


def pairs(triangles: Ints) -> tuple[Ints, Ints]:
    """Triangles (k, 2) at each edge, and (k, 2) its points; edges with two triangles only."""
    ends = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    owner = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort(np.sort(ends, axis=1).T)
    key = np.sort(ends, axis=1)[order]
    same = (key[1:] == key[:-1]).all(axis=1)
    first = np.flatnonzero(same)
    return np.stack([owner[order[first]], owner[order[first + 1]]], axis=1), ends[order[first]]


def edge_counts(triangles: Ints) -> tuple[Ints, Ints]:
    """All edges (k, 2), and (k,) how many triangles each has."""
    ends = np.sort(np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
    return np.unique(ends, axis=0, return_counts=True)


def consistent(points: Floats, triangles: Ints) -> Ints:
    """The triangles in their order, all seen from outside of the solid.

    Outer shells enclose a positive volume, and shells within them a negative one.
    """
    import pyvista as pv

    mesh = pv.PolyData(points, faces=np.insert(triangles, 0, 3, axis=1).ravel())
    turned = mesh.compute_normals(
        cell_normals=True, point_normals=False, split_vertices=False, consistent_normals=True,
        auto_orient_normals=False,
    )  # fmt: skip
    oriented = np.array(turned.regular_faces, dtype=np.int64)
    part = Faces(points, oriented, np.zeros(len(oriented), np.int64)).components()
    outer = _outer(points, oriented, part)
    for number in range(part.max() + 1):
        mine = part == number
        volume = Faces(points, oriented[mine], np.zeros(mine.sum(), np.int64)).volumes.sum()
        if (volume > 0) != outer[number]:
            oriented[mine] = oriented[mine][:, ::-1]
    return oriented


def _outer(points: Floats, triangles: Ints, part: Ints) -> np.ndarray:
    """Mask, (parts,): whether a shell lies in an even number of others."""
    from dolfingrip.meshes.closed_surface import ClosedSurface

    count = int(part.max()) + 1
    depth = np.zeros(count, dtype=int)
    boxes = [points[triangles[part == i]].reshape(-1, 3) for i in range(count)]
    for i in range(count):
        for j in range(count):
            low, high = boxes[j].min(axis=0), boxes[j].max(axis=0)
            if (
                i == j
                or (boxes[i].min(axis=0) <= low).any()
                or (boxes[i].max(axis=0) >= high).any()
            ):
                continue
            shell = triangles[part == j]
            if ClosedSurface(points, shell).volume_mm3 < 0:
                shell = shell[:, ::-1]
            depth[i] += bool(ClosedSurface(points, shell).distances_mm(boxes[i][:1])[0] < 0)
    return depth % 2 == 0


def segmented(points: Floats, triangles: Ints, policy: FacePolicy) -> Ints:
    """Faces of a surface without faces, (m,): planes first, then what has no crease between it.

    A flat piece is a face of its own if it has creases all around, or is much wider than the flat
    pieces that follow it without a crease. Else it is a facet of a curved face.
    """
    plain = Faces(points, triangles, np.zeros(len(triangles), np.int64), policy)
    at, ends = plain.pairs
    cosine = np.einsum("ij,ij->i", plain.normals[at[:, 0]], plain.normals[at[:, 1]])
    flat = parts_of(at[cosine > np.cos(np.radians(policy.flat_deg))], len(triangles))
    flats = replace(plain, face=flat)
    follows = cosine > np.cos(np.radians(policy.crease_deg))
    smooth = follows & (flat[at[:, 0]] != flat[at[:, 1]])
    is_plane = (flats.plane & ~_facets(flats, at[smooth], ends[smooth]))[flat]
    curved = ~is_plane[at].any(axis=1) & follows
    same = is_plane[at].all(axis=1) & (flat[at[:, 0]] == flat[at[:, 1]])
    return parts_of(at[curved | same], len(triangles))


def _facets(flats: Faces, at: Ints, ends: Ints) -> np.ndarray:
    """Mask, (f,): whether a flat piece is not much wider than one that follows it without a crease.

    Args:
        flats: with flat pieces as faces.
        at: (k, 2) triangles, and
        ends: (k, 2) points of the edges without a crease between two pieces.
    """
    order = np.argsort(flats.face, kind="stable")
    starts = np.searchsorted(flats.face[order], np.arange(len(flats.face_areas) + 1))
    corners = [flats.points[np.unique(flats.triangles[order[a:b]])] for a, b in pairwise(starts)]
    result = np.zeros(len(corners), dtype=bool)
    way = flats.points[ends[:, 1]] - flats.points[ends[:, 0]]
    way /= np.maximum(np.linalg.norm(way, axis=1), 1e-300)[:, None]
    for rows, along in zip(at, way, strict=True):
        pieces = flats.face[rows]
        across = np.cross(flats.normals[rows], along)
        wide = [
            float(np.ptp(corners[piece] @ one)) for piece, one in zip(pieces, across, strict=True)
        ]
        for i in (0, 1):
            result[pieces[i]] |= wide[i] < flats.policy.wider * wide[1 - i]
    return result


def united(surface: Faces) -> Faces:
    """The surface with neighbouring faces in one plane as one, as a drawing may divide them."""
    at, _ = surface.pairs
    cosine = np.einsum("ij,ij->i", surface.normals[at[:, 0]], surface.normals[at[:, 1]])
    flat = surface.plane[surface.face[at]].all(axis=1)
    links = surface.face[at[flat & (cosine > np.cos(np.radians(surface.policy.flat_deg)))]]
    return replace(surface, face=parts_of(links, len(surface.face_areas))[surface.face])


def outlines(surface: Faces) -> list[Outline]:
    """All closed lines on the borders of faces."""
    at, ends = surface.pairs
    border = np.flatnonzero(surface.face[at[:, 0]] != surface.face[at[:, 1]])
    lines = []
    rows = np.concatenate([border, border])
    side = np.repeat([0, 1], len(border))
    face = surface.face[at[rows, side]]
    order = np.argsort(face, kind="stable")
    starts = np.flatnonzero(np.diff(face[order], prepend=-1))
    for group in np.split(order, starts[1:]) if len(order) else []:
        mine, here = rows[group], side[group]
        turned = np.where(here[:, None] == 0, ends[mine], ends[mine][:, ::-1])
        nodes, local = np.unique(turned, return_inverse=True)
        part = parts_of(local.reshape(-1, 2), len(nodes))[local.reshape(-1, 2)[:, 0]]
        for number in range(part.max() + 1):
            one = part == number
            beyond = at[mine[one], 1 - here[one]]
            lines.append(Outline(int(face[group[0]]), mine[one], turned[one], beyond))
    return lines
