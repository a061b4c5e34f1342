"""Contact of a deformable surface with a rigid body, by the body's signed distance."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import cached_property
from typing import ClassVar

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import cpp, fem
from mpi4py import MPI

from dolfingrip.forms import plate as form
from dolfingrip.mechanics.contact.density import Density
from dolfingrip.mechanics.contact.distance import KEPT, MovingPoints, SignedDistance
from dolfingrip.mechanics.contact.node_set import NodeSet, RelativeNodes, weights
from dolfingrip.mechanics.contact.pose_contact import (
    AROUND,
    Near,
    PoseContact,
    curvatures,
    slopes,
)
from dolfingrip.mechanics.contact.tangential import Tangential
from dolfingrip.mechanics.model.assembly import owned_vector
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.placement import to_reference, to_world
from dolfingrip.mechanics.model.pose import SIX, Pose, rotation
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.term import Coupling
from dolfingrip.mechanics.model.unknowns import NODE, Gradient


class SkinPoints:
    """The nodes of named regions that this rank owns.

    The rule of :func:`dolfingrip.forms.plate.nodal_rule` integrates at the nodes, so that an
    integral over the reference surface is a sum over them, each with its area.

    Args:
        space: of the displacement.
        domain: reference configuration.
        regions: names of the parts of its boundary.

    Attributes:
        nodes: (n,) local numbers.
        areas: (n,) shares of the nodes in the reference area (mm²).
        rest: (n, 3) undeformed positions in the world (mm).
        frames: (n, 3, 3) from reference axes to the world's; None if they are equal.
        measure: measure of the regions, integrated at the nodes.
        first: global number of this rank's first node.
        owned: number of nodes that this rank owns.
    """

    def __init__(self, space: fem.FunctionSpace, domain: Domain, regions: Sequence[str]) -> None:
        self.first = space.dofmap.index_map.local_range[0]
        self.owned = space.dofmap.index_map.size_local
        cell = domain.mesh.topology.cell_type
        facet = cpp.mesh.cell_entity_type(cell, 2, 0).name
        rule = form.nodal_rule(facet, space.ufl_element().degree)
        self.measure = domain.surface(*regions, **rule)
        test = ufl.TestFunction(space)
        shares = owned_vector(test[0] * self.measure)[::NODE]
        # a rank may own a node of a facet that only another rank has
        self.nodes = np.flatnonzero(shares > 0).astype(np.int32)
        self.areas = shares[self.nodes]
        self.rest = space.tabulate_dof_coordinates()[self.nodes]
        self.frames: np.ndarray | None = None
        if domain.placement is not None:
            self.frames = domain.placement.frames(self.rest)
            self.rest = domain.placement.positions(self.rest)
        self._velocity, normal = fem.Function(space), ufl.FacetNormal(space.mesh)
        stretch = ufl.div(self._velocity) - ufl.inner(normal, ufl.grad(self._velocity) * normal)
        self._rate = test[0] * stretch * self.measure
        self._density = fem.Function(space)
        self._share = self._density[0] * self.measure

    def positions(self, dofs: np.ndarray) -> np.ndarray:
        """Deformed positions (mm), (n, 3)."""
        return self.rest + self.displacement(dofs)

    def displacement(self, local: np.ndarray) -> np.ndarray:
        """Vectors in the world, from a local array at the displacement's nodes (mm), (n, 3)."""
        return to_world(self.frames, local.reshape(-1, NODE)[self.nodes])

    def to_reference(self, vectors: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Vectors (m, 3, …) of the world at some points, in reference axes."""
        return to_reference(None if self.frames is None else self.frames[rows], vectors)

    def area_rates(self, velocity: np.ndarray) -> np.ndarray:
        """Change of the areas (mm²) as reference points move, (n,): A div_Γ v.

        Args:
            velocity: local array of the displacement's nodes.
        """
        self._velocity.x.array[:] = velocity
        return owned_vector(self._rate)[NODE * self.nodes]

    def moved(self, change: np.ndarray) -> SkinPoints:
        """The points after the reference nodes have moved a little by ``change`` (mm)."""
        other = copy(self)
        other.rest = self.rest + self.displacement(change)
        other.areas = self.areas + self.area_rates(change)
        return other

    def add_shape_gradient(
        self, gradient: ShapeGradient, rows: np.ndarray, densities: np.ndarray, forces: np.ndarray
    ) -> None:
        """Add the derivatives of Σ A b by the reference coordinates.

        Args:
            gradient: what is added to.
            rows: (m,) places of some points in :attr:`nodes`.
            densities: (m,) b of each, for a unit of area.
            forces: (m, 3) derivatives of Σ A b by the places of the points in the world.
        """
        self._density.x.array[:] = 0.0
        self._density.x.array[NODE * self.nodes[rows]] = densities
        self._density.x.scatter_forward()
        gradient.add_form(self._share)
        gradient.at_nodes[self.nodes[rows]] += self.to_reference(forces, rows)


class RigidContact(PoseContact):
    """Points of a deformable surface stay outside a rigid body.

    Π = Σ A_i b(φ(Rᵀ(x_i − c))) over the surface's nodes x_i with their shares A_i of the reference
    area. φ is the body's signed distance and b a barrier's energy per area. The body's pose (c, θ)
    is fixed or solved for. Barrier contact between two meshes also pushes along normals of edges,
    so that flat vertical faces hold a body that only friction should hold. A smooth distance does
    not.

    Args:
        u: displacement (mm).
        domain: reference configuration.
        regions: names of the parts of its boundary that may touch.
        shape: the body's signed distance.
        pose: of the body.
        density: the barrier.
    """

    name: ClassVar[str] = "rigid contact"
    passes: ClassVar[str] = "the skin passes through a rigid body"

    def __init__(
        self,
        u: fem.Function,
        domain: Domain,
        regions: Sequence[str],
        shape: SignedDistance,
        pose: Pose,
        density: Density,
    ) -> None:
        super().__init__(shape, pose, density, domain.copies)
        self.points = SkinPoints(u.function_space, domain, regions)
        self._space = u.function_space
        self._comm = u.function_space.mesh.comm
        self._unmoved: SkinPoints | None = None
        self._found: tuple[SignedDistance, np.ndarray, np.ndarray, Near] | None = None

    # -- geometry --------------------------------------------------------------------------------

    def gaps_mm(self, dofs: np.ndarray) -> np.ndarray:
        """Distances of this rank's points from the body, (n,)."""
        q = self.pose.coordinates
        arms = self.points.positions(dofs) - q[:3]
        return self.shape.at(arms @ rotation(q[3:]).matrix).value

    def near(self, dofs: np.ndarray) -> Near:
        """Distances are kept for the next call with the same positions."""
        q = self.pose.coordinates
        positions = self.points.positions(dofs)
        if self._found is not None:
            shape, at, there, near = self._found
            same = np.array_equal(at, positions) and np.array_equal(there, q)
            if same and shape is self.shape:
                return near
        turned = rotation(q[3:]).inverse
        arms = positions - q[:3]
        beyond = np.linalg.norm(arms, axis=1) - self.shape.bounds.radius_mm
        around = np.flatnonzero(beyond < AROUND * self.density.width_mm)
        some, distances, barrier = self._felt(arms[around] @ turned.matrix.T)
        rows = around[some]
        areas = self.points.areas[rows]
        near = Near(rows, arms[rows], areas, turned, -turned.matrix, distances, barrier)
        self._found = (self.shape, positions, q, near)
        return near

    def _moving(self, dofs: np.ndarray, step: np.ndarray) -> MovingPoints:
        q, change = self.pose.coordinates, self.pose.change(step)
        arms = self.points.positions(dofs) - q[:3]
        drift = self.points.displacement(step[: len(dofs)]) - change[:3]
        # most points are too far away to touch in this step, whatever their direction
        away, speed = (np.linalg.norm(vectors, axis=1) for vectors in (arms, drift))
        turn = float(np.linalg.norm(change[3:]))
        beyond = away - self.shape.bounds.radius_mm
        close = (1 - KEPT) * beyond <= turn * (away + speed) + speed
        still = np.zeros(3)
        return MovingPoints(arms[close], drift[close], still, still, q[3:], change[3:], back=True)

    # -- the potential ---------------------------------------------------------------------------

    def _sum[T](self, local: T) -> T:
        return self._comm.allreduce(local, MPI.SUM)

    def _least(self, local: float) -> float:
        return float(self._comm.allreduce(local, MPI.MIN))

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the derivatives by the points and by the pose (N, N mm)."""
        near = self.near(dofs)
        nodes = self.points.nodes[near.rows]
        gradient.at_nodes[nodes] += self.points.to_reference(_at_points(near), near.rows)
        if self.pose.free:
            self.pose.add_slopes(self._sum(slopes(near)), gradient)

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """Second derivatives at this rank's points, and by the pose if it is solved for."""
        near = self.near(dofs)
        at_points, with_pose, within = _curvatures(near, convex=convex)
        at_points = self.points.to_reference(at_points, near.rows)
        at_points = self.points.to_reference(at_points.transpose(0, 2, 1), near.rows)
        with_pose = self.points.to_reference(with_pose, near.rows)
        nodes, count = self.points.nodes[near.rows], len(near.rows)
        places = np.arange(count + 1)
        hessian = sp.bsr_matrix((at_points, places[:-1], places), (3 * count, 3 * count))
        couplings = [Coupling(self.points.first + nodes, hessian.tocoo())]
        if self.pose.free:
            mixed = np.zeros((SIX, self.points.owned, NODE))
            mixed[:, nodes] = with_pose.transpose(2, 0, 1)
            flat = mixed.reshape(SIX, -1)
            couplings += self.pose.coupling(self.points.first, flat, self._sum(within))
        return couplings

    # -- for friction ----------------------------------------------------------------------------

    @cached_property
    def touching(self) -> NodeSet:
        """Nodes of the skin that may touch the body, and the body."""
        owned_nodes = self.points.first + self.points.nodes.astype(np.int64)
        every, first = np.unique(self._gathered(owned_nodes), return_index=True)
        frames = self.points.frames
        if frames is not None:
            frames = self._gathered(frames)[first]
        return RelativeNodes(self._space, every, frames, [self.pose])

    def tangential(self, dofs: np.ndarray) -> Tangential:
        """Nodes within the barrier's width, each paired with the body's point below it."""
        near = self.near(dofs)
        pressed = np.flatnonzero(near.barrier.slope < 0)
        owned_nodes = self.points.first + self.points.nodes[near.rows[pressed]].astype(np.int64)
        below = near.arms[pressed] @ near.turned.matrix.T
        keys, normals, normal_N, rise, below = (
            self._gathered(values)
            for values in (
                owned_nodes,
                near.distances.gradient[pressed] @ near.turned.matrix,
                -(near.areas * near.barrier.slope)[pressed],
                (near.areas * near.barrier.curvature)[pressed],
                below,
            )
        )
        lengths = np.linalg.norm(normals, axis=1)  # of a sampled distance not quite 1
        nodes = self.touching.nodes
        count = len(keys)
        one = (np.ones(count), (np.arange(count), np.searchsorted(nodes, keys)))
        at_nodes = sp.csr_matrix(one, shape=(count, len(nodes)))
        at_rows = sp.hstack([at_nodes, sp.csr_matrix(-weights(below))], format="csr")
        # the force is N |∇φ|, and φ falls by |∇φ| for each mm
        return Tangential(
            at_rows,
            normals / lengths[:, None],
            lengths * normal_N,
            lengths**2 * rise,
            keys[:, None],
        )

    def _gathered(self, values: np.ndarray) -> np.ndarray:
        """Rows of all ranks, in the ranks' order."""
        return np.concatenate(self._comm.allgather(values))

    # -- derivatives by parameters ---------------------------------------------------------------

    def pose_rate(self, dofs: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """Change of the gradient at owned nodes for a motion (6,) of the pose, (n, 3)."""
        near = self.near(dofs)
        changes = np.zeros((self.points.owned, NODE))
        changed = _curvatures(near, convex=False)[1] @ motion
        changes[self.points.nodes[near.rows]] = self.points.to_reference(changed, near.rows)
        return changes

    def pose_curvature(self, dofs: np.ndarray) -> np.ndarray:
        """This rank's part of the second derivatives by the pose, (6, 6)."""
        return _curvatures(self.near(dofs), convex=False)[2]

    def add_shape_gradient(self, dofs: np.ndarray, gradient: ShapeGradient) -> None:
        """Add the derivatives by the points' rest places and by their areas."""
        near = self.near(dofs)
        self.points.add_shape_gradient(gradient, near.rows, near.barrier.energy, _at_points(near))

    def add_load_shape_gradient(
        self, dofs: np.ndarray, motion: np.ndarray, gradient: ShapeGradient, factor: float
    ) -> None:
        """Add ``factor`` times the derivatives of ∂Π/∂q · motion by the reference coordinates.

        Args:
            dofs: displacement.
            motion: (6,) motion of the pose q.
            gradient: what is added to.
            factor: multiplies what is added.
        """
        near = self.near(dofs)
        speeds = np.einsum("ni,nik,k->n", near.distances.gradient, near.motion, motion)
        changed = _curvatures(near, convex=False)[1] @ motion
        densities = near.barrier.slope * speeds
        self.points.add_shape_gradient(gradient, near.rows, factor * densities, factor * changed)

    def move_reference(self, change: np.ndarray | None) -> None:
        """Move the points by ``change`` (local array, mm); None: put them back."""
        if self._unmoved is None:
            self._unmoved = self.points
        self.points = self._unmoved if change is None else self._unmoved.moved(change)
        self._found = None
        if change is None:
            self._unmoved = None


def _at_points(near: Near) -> np.ndarray:
    """Derivatives of Π by the points' places in the world (N), (n, 3)."""
    return np.asarray(near.forces @ near.turned.matrix)


def _curvatures(near: Near, *, convex: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Second derivatives by points (n, 3, 3), by points and pose (n, 3, 6), by the pose (6, 6).

    Args:
        near: the points.
        convex: without the parts of the distance's and the rotation's curvature.
    """
    back = near.turned.matrix
    curved = near.curved(convex=convex)
    at_points = np.einsum("ji,njl,lm->nim", back, curved, back)
    with_pose = np.einsum("ji,njl,nlk->nik", back, curved, near.motion)
    within = curvatures(near, convex=convex)
    if not convex:  # forces turn with the body
        turning = np.einsum("kji,nj->nik", near.turned.first, near.forces)
        with_pose[:, :, 3:] += turning
        within[:3, 3:] -= turning.sum(axis=0)
        within[3:, :3] = within[:3, 3:].T
    return at_points, with_pose, within
