"""Hollows of a solid: shells inside it, and pockets with openings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dolfingrip.meshes.adoption.surface import Faces, Outline, outlines
from dolfingrip.meshes.solid import Floats, Ints, MeshError, parts_of


@dataclass(frozen=True, slots=True, eq=False)
class Opening:
    """An opening of a hollow.

    Attributes:
        face: number of the face that it is in.
        centre_mm: (3,) middle of the rim.
        vector_mm2: (3,) its area vector, out of the solid.
        rim: (k, 2) points of the rim's edges, as the face's triangles turn.
        flat: whether the face that it is in is plane.
    """

    face: int
    centre_mm: Floats
    vector_mm2: Floats
    rim: Ints
    flat: bool

    @property
    def area_mm2(self) -> float:
        """Enclosed area."""
        return float(np.linalg.norm(self.vector_mm2))

    @property
    def normal(self) -> Floats:
        """Unit normal out of the solid, (3,)."""
        return np.asarray(self.vector_mm2 / self.area_mm2)


@dataclass(frozen=True, slots=True, eq=False)
class Hollow:
    """A hollow.

    Attributes:
        triangles: rows of the surface's triangles.
        volume_mm3: enclosed volume, openings closed by flat caps.
        centre_mm: (3,) its centre.
        openings: none of a closed shell.
    """

    triangles: Ints
    volume_mm3: float
    centre_mm: Floats
    openings: tuple[Opening, ...]


def hollows(surface: Faces, held: int = -1) -> tuple[list[Hollow], Ints]:
    """The hollows of a solid, the largest first, and (m,) the shell of each triangle.

    Args:
        surface: closed.
        held: number of the face that is known to be held, whose outlines are rims.

    Raises:
        MeshError: one line, if the surface encloses several solids.
    """
    shell = surface.components()
    volume = np.bincount(shell, surface.volumes)
    outer = np.flatnonzero(volume > 0)
    if len(outer) != 1:
        raise MeshError(f"falls into {len(outer)} parts; allowed: one solid")
    inner = np.flatnonzero(volume <= 0)
    voids = [hollow_of(surface, np.flatnonzero(shell == i)) for i in inner]
    voids += _pockets(surface, shell == outer[0], held)
    return sorted(voids, key=lambda void: -void.volume_mm3), shell


def _pockets(surface: Faces, outer: np.ndarray, held: int) -> list[Hollow]:
    """Hollows of the outer shell: what is connected to its outside over rims alone."""
    at, _ = surface.pairs
    rims = [
        (line, longest)
        for line, longest in _outlines_of(surface, outer)
        if line.face == held or _is_rim(surface, line, longest)
    ]
    cut = np.zeros(len(at), dtype=bool)
    for line, _ in rims:
        cut[line.edges] = True
    part = surface.components(~cut)
    outside = np.zeros(part.max() + 1, dtype=bool)
    outside[part[_extreme(surface, outer)]] = True
    outside[part[surface.face == held]] = True
    # chambers of one cavity are joined by rims, too
    links = part[at[cut]]
    inner = links[~outside[links].any(axis=1)]
    joined = parts_of(inner, len(outside))
    voids = []
    for number in np.unique(joined[part[outer]]):
        if outside[joined == number].any():
            continue
        rows = np.flatnonzero((joined[part] == number) & outer)
        mine = np.zeros(len(part), dtype=bool)
        mine[rows] = True
        mouths = [line for line, _ in rims if mine[line.beyond].all()
                  and outside[part[_on(surface, line)]]]  # fmt: skip
        if mouths:
            voids.append(hollow_of(surface, rows, mouths))
    return voids


def _on(surface: Faces, line: Outline) -> int:
    """A triangle on the outline's own side."""
    pair = surface.pairs[0][line.edges[0]]
    return int(pair[surface.face[pair] == line.face][0])


def _outlines_of(surface: Faces, outer: np.ndarray) -> list[tuple[Outline, float]]:
    """Outlines of the outer shell's faces, and the longest one's length of that face."""
    lines = [line for line in outlines(surface) if outer[line.beyond].all()]
    longest: dict[int, float] = {}
    for line in lines:
        longest[line.face] = max(longest.get(line.face, 0.0), line.length_mm(surface))
    return [(line, longest[line.face]) for line in lines]


def _is_rim(surface: Faces, line: Outline, longest_mm: float) -> bool:
    """Return whether an outline is a hole in its face through which one gets into the solid."""
    vector = line.vector_mm2(surface)
    normal = surface.face_vectors[line.face]
    if surface.plane[line.face]:
        if vector @ normal >= 0:  # the outer outline turns as the face does
            return False
    elif line.length_mm(surface) > surface.policy.rim * longest_mm:
        return False
    # the other side lies below the face: the edge is convex, the hole is no boss
    corners = surface.triangles[line.beyond]
    apex = ~(corners[:, :, None] == line.ends[:, None, :]).any(axis=2)
    tip = surface.points[corners[np.arange(len(corners)), apex.argmax(axis=1)]]
    pair = surface.pairs[0][line.edges]
    on_face = np.where(surface.face[pair[:, 0]] == line.face, pair[:, 0], pair[:, 1])
    ends = surface.points[line.ends]
    height = np.einsum("ij,ij->i", tip - ends[:, 0], surface.normals[on_face])
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return bool(length[height < 0].sum() >= surface.policy.convex * length.sum())


def _extreme(surface: Faces, outer: np.ndarray) -> Ints:
    """Triangles of the outer shell that reach farthest along random directions.

    Of those at the farthest point it is the one that faces that way most: the point may be on an
    opening's rim.
    """
    rows = np.flatnonzero(outer)
    corners = surface.triangles[rows]
    ways = np.random.default_rng(0).normal(size=(surface.policy.directions, 3))
    nodes = np.unique(corners)
    farthest = nodes[np.argmax(surface.points[nodes] @ ways.T, axis=0)]
    extremes = []
    for node in np.unique(farthest):
        mine = rows[(corners == node).any(axis=1)]
        extremes.append(mine[np.argmax(surface.normals[mine] @ ways[farthest == node].T, axis=0)])
    return np.unique(np.concatenate(extremes))


def hollow_of(surface: Faces, rows: Ints, rims: Sequence[Outline] = ()) -> Hollow:
    """Make a hollow of its triangles.

    Args:
        surface: of the part.
        rows: of the triangles.
        rims: outlines of its openings, each in the face that it opens.
    """
    reference = surface.middles[rows].mean(axis=0)
    volumes = -np.einsum("ij,ij->i", surface.middles[rows] - reference, surface.vectors[rows]) / 3
    weight, moment = volumes.sum(), (0.75 * (surface.middles[rows] - reference)).T @ volumes
    openings = []
    for line in rims:
        vector, centre = line.vector_mm2(surface), line.centre_mm(surface)
        out = -vector  # as an inner outline turns against its face
        openings.append(Opening(line.face, centre, out, line.ends, bool(surface.plane[line.face])))
        cap = (centre - reference) @ out / 3
        weight, moment = weight + cap, moment + cap * 0.75 * (centre - reference)
    centre = reference + moment / weight if weight else reference
    return Hollow(rows, float(weight), centre, tuple(openings))
