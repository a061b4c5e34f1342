"""Barrier contact between surfaces (incremental potential contact, through ipctk)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, ClassVar, Final

import ipctk
import numpy as np
import scipy.sparse as sp

from dolfingrip.mechanics.contact.surface import Surface
from dolfingrip.mechanics.contact.tangential import Tangential, Touching
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.term import Coupling
from dolfingrip.mechanics.model.unknowns import Gradient

ipctk.set_num_threads(1)  # one thread a rank, as everywhere


EDGES = 2
"""Kind of the pairs of two edges."""

PARTED: Final = {0: 1, 1: 1, EDGES: 2, 3: 1}
"""Vertices of the first part of a pair, by its kind; those of the second part follow."""

FACING: Final = 0.8
"""Cosine of the angle between the way from one surface to another and both normals, from which they
face one another; above 0.71, which both walls of a right corner have."""

PROJECTION = {False: ipctk.PSDProjectionMethod.NONE, True: ipctk.PSDProjectionMethod.CLAMP}
"""Projection of each pair's Hessian, by whether it must be convex."""


UNALIGNED: Final = 3e-7
"""Part of an edge's length by which vertices are moved at random: no edges then lie on one line."""

TINY: Final = 1e-12
"""Square of the sine of the angle between edges that count as parallel."""

MOVED: Final = 1e-4
"""Part of the barrier's width by which points move for derivatives by differences."""


class BarrierContact(Touching):
    """Surfaces repel one another within the barrier's width and never pass.

    Π_contact = −κ ĝ Σ A (1 − s²)² ln s², s = d/ĝ, over the pairs of vertex–face and edge–edge at
    a distance d below the width ĝ (Li et al. 2020), weighted by area so that it converges with
    the mesh (Li et al., Convergent Incremental Potential Contact, 2023). Unlike the plate's it has
    no stiffness at first touch: as the bellows slide along one another, pairs come and go there,
    and Newton's method would jump between them.

    Args:
        surface: vertices and triangles of all bodies.
        width_mm: distance ĝ at which contact is first felt.
        stiffness_MPa: κ.
        title: what the surface is called where it passes through itself.
        crowded: whether walls are pressed on one another over wide areas.
        separate: whether only separate parts of the surface repel one another, as the two faces of
            a thin wall; what is connected has a contact of its own.
    """

    name: ClassVar[str] = "contact"

    def __init__(
        self,
        surface: Surface,
        width_mm: float,
        stiffness_MPa: float,
        title: str = "the skin",
        *,
        crowded: bool = False,
        separate: bool = False,
    ) -> None:
        self.title, self.crowded, self.separate = title, crowded, separate
        self.surface = surface
        self.width_mm = width_mm
        self._size_mm = float(np.linalg.norm(np.ptp(surface.rest, axis=0)))
        self._jitter = _jitter(surface, UNALIGNED)
        self._mesh = _collision_mesh(surface, self._jitter, separate=separate)
        self._unmoved: tuple[Surface, ipctk.CollisionMesh, Any] | None = None
        self._apart = False
        self._potential = ipctk.BarrierPotential(width_mm, stiffness_MPa, True)
        self._ccd = ipctk.AdditiveCCD()
        self._found: tuple[np.ndarray, ipctk.NormalCollisions] | None = None

    def positions(self, dofs: np.ndarray) -> np.ndarray:
        """Deformed positions (mm) for distances, (v, 3); no two edges lie on one line."""
        return np.asfortranarray(self.surface.positions(dofs) + self._jitter)

    # -- pairs ---------------------------------------------------------------------------------

    def _pairs(
        self, now: np.ndarray, reach_mm: float | None = None, *, by_rest: bool = False
    ) -> ipctk.NormalCollisions:
        """Pairs closer than ``reach_mm`` (default: the barrier's width).

        ``by_rest``: whether their areas have derivatives by the rest places.
        """
        pairs = ipctk.NormalCollisions()
        pairs.enable_shape_derivatives = by_rest
        pairs.use_area_weighting = True
        # The improved maximum counts no pair twice. But its forces jump as pairs come and go, and
        # Newton's method then cycles. The forces of these pairs are continuous.
        pairs.collision_set_type = ipctk.NormalCollisions.CollisionSetType.IPC
        pairs.build(self._mesh, now, self.width_mm if reach_mm is None else reach_mm)
        return pairs

    def _felt(self, now: np.ndarray) -> ipctk.NormalCollisions:
        """Pairs within the barrier's width, kept for the next call at the same positions."""
        if self._apart and self._found is not None:
            return self._found[1]
        if self._found is None or not np.array_equal(self._found[0], now):
            self._found = (now, self._pairs(now))
        return self._found[1]

    # -- energy --------------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ), the same on all ranks."""
        now = self.positions(dofs)
        return float(self._potential(self._felt(now), self._mesh, now))

    def gradient(self, dofs: np.ndarray) -> np.ndarray:
        """Gradient (N) at the surface's nodes, (n, 3)."""
        now = self.positions(dofs)
        pairs = self._felt(now)
        if pairs.empty():
            return np.zeros((len(self.surface.nodes), 3))
        return self.surface.gathered(self._potential.gradient(pairs, self._mesh, now))

    def hessian(self, dofs: np.ndarray, *, convex: bool = False) -> sp.coo_matrix | None:
        """Hessian (N/mm) at the nodes, (3n, 3n); None without contact.

        Args:
            dofs: displacement.
            convex: whether negative eigenvalues of each pair's Hessian are left out.
        """
        now = self.positions(dofs)
        pairs = self._felt(now)
        if pairs.empty():
            return None
        at_vertices = self._potential.hessian(pairs, self._mesh, now, PROJECTION[convex])
        spread = self.surface.spread
        return sp.coo_matrix(spread.T @ at_vertices @ spread)

    def rest_gradient(self, dofs: np.ndarray) -> np.ndarray:
        """Derivatives (N) by the vertices' rest places at fixed deformed positions, (v, 3).

        Rest places decide the pairs' areas, and the lengths up to which nearly parallel edges are
        mollified. ipctk 1.6's own ``shape_derivative`` is 1 % off for pairs of edges.
        """
        gradient = np.zeros_like(self.surface.rest)
        now = self.positions(dofs)
        if self._felt(now).empty():
            return gradient
        if not self._mesh.are_area_jacobians_initialized():
            self._mesh.init_area_jacobians()
        rest_mm, edges, faces = self.surface.rest + self._jitter, self._mesh.edges, self._mesh.faces
        flat = gradient.reshape(-1)
        for (kind, _, _), pair in _known(self._pairs(now, by_rest=True)):
            positions = pair.dof(now, edges, faces)
            energy = self._potential(pair, positions)
            by_area = pair.weight_gradient
            flat[by_area.indices] += energy / pair.weight * by_area.data
            if kind == EDGES and pair.is_mollified():
                ids = pair.vertex_ids(edges, faces)
                a, b, c, d = now[ids]
                sine = float(np.sum(np.cross(b - a, d - c) ** 2))
                mollifier = ipctk.edge_edge_mollifier(sine, pair.eps_x)
                if mollifier > 0:
                    rate = ipctk.edge_edge_mollifier_derivative_wrt_eps_x(sine, pair.eps_x)
                    by_length = ipctk.edge_edge_mollifier_threshold_gradient(*rest_mm[ids])
                    gradient[ids] += energy / mollifier * rate * np.reshape(by_length, (4, 3))
        return gradient

    # -- for friction --------------------------------------------------------------------------

    @property
    def touching(self) -> Surface:
        """The surface; all pairs move with its nodes."""
        return self.surface

    def tangential(self, dofs: np.ndarray) -> Tangential:
        """Pairs within the barrier's width, with closest points, normals and normal forces.

        ipctk's own tangential collisions leave out edges that are nearly parallel. Its mollified
        barrier gives such a pair a normal force, too, so these are computed here for all pairs.
        """
        now = self.positions(dofs)
        pairs = self._felt(now)
        if pairs.empty():
            return Tangential.none(len(self.surface.nodes), width=3)
        keyed_pairs = list(_known(pairs))
        contacts = [self._pressed(pair, now) for _, pair in keyed_pairs]
        vertices, shares, distances, forces, rises = zip(*contacts, strict=True)
        rows = np.repeat(np.arange(len(contacts)), [len(ids) for ids in vertices])
        places = (rows, np.concatenate(vertices))
        shape = (len(contacts), len(now))
        at_vertices = sp.csr_matrix((np.concatenate(shares), places), shape=shape)
        apart = np.array(distances)
        return Tangential(
            sp.csr_matrix(at_vertices @ self.surface.weights),
            apart / np.linalg.norm(apart, axis=1)[:, None],
            np.array(forces),
            np.array(rises),
            np.array([key for key, _ in keyed_pairs]),
        )

    def _pressed(
        self, pair: ipctk.NormalCollision, now: np.ndarray
    ) -> tuple[list[int], np.ndarray, np.ndarray, float, float]:
        """Vertices of a pair, their weights in its distance vector (mm), its normal force and rise.

        The rise (N/mm) is the change of the normal force by the distance alone.
        """
        edges, faces = self._mesh.edges, self._mesh.faces
        vertices = [v for v in pair.vertex_ids(edges, faces) if v >= 0]
        positions = pair.dof(now, edges, faces)
        apart, shares = pair.compute_distance_vector_with_coefficients(positions)
        weight = pair.weight * (pair.mollifier(positions) if pair.is_mollified() else 1.0)
        force, nearer = (
            weight * self._potential.force_magnitude(part**2 * float(apart @ apart), pair.dmin)
            for part in (1.0, 1 - MOVED)
        )
        rise = (nearer - force) / (MOVED * float(np.linalg.norm(apart)))
        return vertices, shares, apart, float(force), float(rise)

    # -- as a term -----------------------------------------------------------------------------

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the derivatives (N) by the nodes that this rank owns."""
        self.surface.add_owned(self.gradient(dofs), gradient.at_nodes)

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """The whole Hessian, equal on all ranks."""
        hessian = self.hessian(dofs, convex=convex)
        if hessian is None:
            return ()
        return [Coupling(self.surface.nodes, self.surface.in_reference(hessian))]

    def add_shape_gradient(self, dofs: np.ndarray, gradient: ShapeGradient) -> None:
        """Add the derivatives by the nodes' rest places, which also move the deformed surface."""
        forces = self.gradient(dofs)
        forces += self.surface.gathered(self.rest_gradient(dofs))
        self.surface.add_owned(forces, gradient.at_nodes)

    def move_reference(self, change: np.ndarray | None) -> None:
        """Move the surface's vertices a little with their nodes; None puts them back.

        If no pair is active, none becomes active by such a small move, so none is sought.
        """
        if self._unmoved is None:
            self._unmoved = (self.surface, self._mesh, self._found)
        self.surface, self._mesh, self._found = self._unmoved
        self._apart = change is not None and self._found is not None and self._found[1].empty()
        if change is None:
            self._unmoved = None
            return
        self.surface = self.surface.moved(self.surface.displacement(change))
        if not self._apart:
            self._mesh = _collision_mesh(self.surface, self._jitter, separate=self.separate)
            self._found = None

    def rejects(self, dofs: np.ndarray) -> str:
        """A state in which surfaces intersect."""
        return f"{self.title} passes through itself" if self.intersects(dofs) else ""

    # -- bounds --------------------------------------------------------------------------------

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest fraction of ``step`` in [0, 1] without a collision.

        No vertex moves farther than the surface is large: a diverging iteration asks for steps of
        ten times that, along which nearly all pairs might collide. To check them takes minutes and
        several GB.
        """
        start = self.positions(dofs)
        moved = self.surface.displacement(step[: len(dofs)])
        longest_mm = float(np.linalg.norm(moved, axis=1).max(initial=0.0))
        part = min(self._size_mm / longest_mm, 1.0) if longest_mm > 0 else 1.0
        end = np.asfortranarray(start + part * moved)
        return part * float(
            ipctk.compute_collision_free_stepsize(
                self._mesh, start, end, narrow_phase_ccd=self._ccd
            )
        )

    def gap_mm(self, dofs: np.ndarray, reach_mm: float) -> float:
        """Smallest distance between parts closer than ``reach_mm``; infinite if there are none."""
        now = self.positions(dofs)
        close = self._pairs(now, reach_mm)
        return float(np.sqrt(close.compute_minimum_distance(self._mesh, now)))

    def opposite_mm(self, dofs: np.ndarray, reach_mm: float) -> float:
        """Smallest distance of parts that face one another, as walls beside a corner do not.

        Args:
            dofs: displacement.
            reach_mm: distance beyond which parts are not looked at.

        Returns:
            The distance (mm); infinite where no parts that face one another are as near.
        """
        now, edges, faces = self.positions(dofs), self._mesh.edges, self._mesh.faces
        a, b, c = (now[faces[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        identities = np.array([key for key, _ in _known(self._pairs(now, reach_mm))], dtype=int)
        if not len(identities):
            return np.inf
        ids, apart = _between(identities, now, edges, faces)
        of_first = np.arange(4) < np.array(list(PARTED.values()))[identities[:, :1]]
        far, around = np.linalg.norm(apart, axis=1), _around(faces, len(now))
        face = np.ones(len(identities), dtype=bool)
        for part in ((ids >= 0) & of_first, (ids >= 0) & ~of_first):
            beside = around[np.take_along_axis(ids, part.argmax(axis=1)[:, None], axis=1)[:, 0]]
            has = (faces[beside][..., None] == ids[:, None, None]).any(axis=2)
            holds = (has | ~part[:, None]).all(axis=2)  # triangles that have the part's vertices
            along = np.abs(np.einsum("nki,ni->nk", normals[beside], apart))
            face &= (along * holds).max(axis=1) > FACING * far
        return float(far[face].min(initial=np.inf))

    def intersects(self, dofs: np.ndarray) -> bool:
        """Return whether any two triangles pass through one another."""
        return bool(ipctk.has_intersections(self._mesh, self.positions(dofs)))


def _collision_mesh(surface: Surface, jitter: np.ndarray, *, separate: bool) -> ipctk.CollisionMesh:
    faces = np.asfortranarray(surface.triangles)
    mesh = ipctk.CollisionMesh(
        np.asfortranarray(surface.rest + jitter), np.asfortranarray(surface.edges), faces
    )
    if separate:
        mesh.can_collide = ipctk.make_connected_components_filter(faces)
    return mesh


def _around(faces: np.ndarray, count: int) -> np.ndarray:
    """Triangles around each vertex, (count, most); the last one again where it has fewer."""
    order = np.argsort(faces, axis=None)
    numbers = np.bincount(faces.ravel(), minlength=count)
    starts = np.cumsum(numbers) - numbers
    place = np.minimum(np.arange(numbers.max()), np.maximum(numbers - 1, 0)[:, None])
    triangles = np.append(order // 3, 0)  # a vertex of no triangle is in no pair
    return np.asarray(triangles[np.minimum(starts[:, None] + place, len(order))])


def _known(
    pairs: ipctk.NormalCollisions,
) -> Iterator[tuple[tuple[int, int, int], ipctk.NormalCollision]]:
    """Pairs with their identities: the kind, and the numbers of both parts."""
    yield from (((0, c.vertex0_id, c.vertex1_id), c) for c in pairs.vv_collisions)
    yield from (((1, c.edge_id, c.vertex_id), c) for c in pairs.ev_collisions)
    yield from (((EDGES, c.edge0_id, c.edge1_id), c) for c in pairs.ee_collisions)
    yield from (((3, c.face_id, c.vertex_id), c) for c in pairs.fv_collisions)


def _between(
    identities: np.ndarray, now: np.ndarray, edges: np.ndarray, faces: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 4) of pairs, −1 beyond the last one, and (n, 3) ways (mm) between their parts.

    The kind of a pair tells where its parts are nearest: within its edge, or its triangle.
    """
    kind, first, second = identities.T
    corners, lines, crossings, sides = (np.flatnonzero(kind == number) for number in range(4))
    ids = np.full((len(kind), 4), -1)
    ids[corners, :2] = identities[corners, 1:]
    ids[lines, :3] = np.column_stack([second[lines], edges[first[lines]]])
    ids[crossings] = np.column_stack([edges[first[crossings]], edges[second[crossings]]])
    ids[sides] = np.column_stack([second[sides], faces[first[sides]]])
    a, b, c, d = (now[ids[:, place]] for place in range(4))
    apart = a - b
    apart[lines] -= _along(apart[lines], (c - b)[lines])
    normals = np.cross(c - b, d - b)[sides]
    apart[sides] = _along(apart[sides], normals)
    u, v, w = (b - a)[crossings], (d - c)[crossings], (a - c)[crossings]
    uu, uv, vv, uw, vw = (_dot(*pair) for pair in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    # edges that are nearly parallel may be nearest at an end (Ericson 2005, section 5.1.9)
    on_second = (uu * vw - uv * uw) / np.maximum(uu * vv - uv**2, TINY * uu * vv)
    on_first = ((uv * on_second.clip(0, 1)) - uw) / uu
    on_second = (uv * on_first.clip(0, 1) + vw) / vv
    apart[crossings] = w + on_first.clip(0, 1) * u - on_second.clip(0, 1) * v
    return ids, apart


def _dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Products of rows, (n, 1)."""
    return np.sum(first * second, axis=1, keepdims=True)


def _along(ways: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Parts of ``ways`` along ``lines``, (n, 3)."""
    return np.asarray(lines * _dot(ways, lines) / _dot(lines, lines))


def _jitter(surface: Surface, part: float) -> np.ndarray:
    """Random displacement (mm) of the vertices, at most this part of an edge, (v, 3).

    ipctk 1.6 takes edges on one line that rounding turns by 1e-8 for edges that cross, at a
    distance of 0 whose barrier is infinite; and the corners of neighbouring bellows are such edges.
    """
    ends = surface.rest[surface.triangles]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean()
    by = np.random.default_rng(0).uniform(-1, 1, surface.rest.shape)
    return np.asarray(part * length / np.sqrt(3) * by)
