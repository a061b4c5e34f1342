"""The force-sensor plate: a rigid plane that faces part of the skin."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem
from petsc4py import PETSc

from dolfingrip.mechanics.contact.density import TwoStage
from dolfingrip.mechanics.contact.distance import Plane
from dolfingrip.mechanics.contact.node_set import NodeSet
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.contact.tangential import Tangential
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.pose import SIX, Pose
from dolfingrip.mechanics.model.unknowns import GlobalUnknown

AWAY_mm = 1e4
"""Distance (mm) from the finger at which a retracted plate stands."""


EQUAL_mm = 1e-7
"""Difference of distances from the plate (mm) that rounding makes of none."""


class RigidPlate(RigidContact):
    """The plane n · x = offset; the skin stays on the side that n points to.

    The plane lies one barrier width behind the position that first feels the skin, so that a
    gap of 0 is a touch without force.

    Args:
        u: displacement (mm).
        domain: reference configuration.
        region: name of the part of ``domain``'s boundary that may touch.
        normal: (3,) towards the finger; any length.
        gap_mm: distance that the nearest point of ``region`` travels along −n until contact is
            felt. It counts from the shape against which the plate is put; the first such shape is
            the undeformed one.
        width_mm: barrier width ĝ.
        stiffness_MPa: barrier stiffness κ.

    Attributes:
        normal: (3,) of length 1, towards the finger.
        offset: the plane's position along n (mm), its pose's only coordinate.
        unloaded: constant: the position at which a compliant plate stands without force (mm).
    """

    name: ClassVar[str] = "plate"

    def __init__(
        self,
        u: fem.Function,
        domain: Domain,
        region: str,
        normal: np.ndarray,
        *,
        gap_mm: float,
        width_mm: float,
        stiffness_MPa: float,
    ) -> None:
        mesh = domain.mesh
        self.offset, self.unloaded = (fem.Constant(mesh, PETSc.ScalarType(0.0)) for _ in range(2))
        self.normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        density = TwoStage(width_mm, stiffness_MPa)
        shape, pose = Plane(tuple(self.normal)), Pose([self.offset], self.motion, np.zeros(SIX))
        super().__init__(u, domain, [region], shape, pose, density)
        self.width_mm = width_mm
        self._u = u
        self._gap_mm = gap_mm
        self._away = False
        self.put()

    @property
    def motion(self) -> np.ndarray:
        """Motion of the pose along the normal, (6,)."""
        return np.concatenate([self.normal, np.zeros(3)])

    @property
    def unknown(self) -> GlobalUnknown | None:
        """The plane's position as an unknown; None if it is prescribed."""
        return self.pose.global_unknowns[0]

    def solve_for(self, unknown: GlobalUnknown) -> None:
        """Make the plane's position an unknown; call it before there is a model."""
        self.pose.global_unknowns[0] = unknown

    # -- for friction ----------------------------------------------------------------------------

    @cached_property
    def touching(self) -> NodeSet:
        """Nodes of the skin that may touch the plane."""
        owned_nodes = self.points.first + self.points.nodes.astype(np.int64)
        return NodeSet(self._space, np.unique(self._gathered(owned_nodes)))

    def tangential(self, dofs: np.ndarray) -> Tangential:
        """Nodes that touch the plane, with their parts of its force.

        The plane moves along its normal alone.
        """
        near = self.near(dofs)
        shares = np.zeros((self.points.owned, 3))
        shares[self.points.nodes[near.rows], 0] = -near.areas * near.barrier.slope
        shares[self.points.nodes[near.rows], 1] = near.areas * near.barrier.curvature
        normal_N, rise, _ = self.touching.at_nodes(shares.ravel()).T
        pressed = np.flatnonzero(normal_N > 0)
        return Tangential(
            sp.eye_array(len(normal_N), format="csr")[pressed],
            np.tile(self.normal, (len(pressed), 1)),
            normal_N[pressed],
            rise[pressed],
            self.touching.nodes[pressed, None],
        )

    def facing(self, step: np.ndarray) -> np.ndarray:
        """Displacement of the plane for a step of the unknowns, (3,)."""
        return self.pose.change(step)[:3]

    @property
    def measure(self) -> ufl.Measure:
        """Measure of the part of the skin that may touch the plane, integrated at the nodes."""
        return self.points.measure

    # -- readings --------------------------------------------------------------------------------

    def force_N(self) -> float:
        """Normal force on the whole finger's plate."""
        return -float(self.load_N(self._u.x.array)[:3] @ self.normal)

    def gap_mm(self) -> float:
        """Smallest distance of the skin's nodes from the plane."""
        return self._least(float(self.gaps_mm(self._u.x.array).min(initial=np.inf)))

    # -- where it is put -------------------------------------------------------------------------

    def put(self, place_mm: float | None = None) -> None:
        """Put the plate at its gap from the present shape, or at a place along its normal (mm)."""
        self.offset.value = self.unloaded.value = self.place_mm() if place_mm is None else place_mm
        self._away = False

    def retract(self) -> None:
        """Move the plate away from the finger."""
        self.put(self.place_mm() - AWAY_mm)
        self._away = True

    def turn(self, normal: np.ndarray, gap_mm: float, dofs: np.ndarray) -> None:
        """Give the plate another normal, and a gap from the skin displaced by ``dofs``.

        A position that is solved for stays, and its spring's end moves. A retracted plate stays
        retracted.
        """
        self.normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        self.shape = Plane(tuple(self.normal))
        self.pose = Pose([self.offset], self.motion, np.zeros(SIX), self.pose.global_unknowns)
        self._gap_mm = gap_mm
        if self._away:
            return
        self.unloaded.value = self.place_mm(dofs)
        if self.unknown is None:
            self.offset.value = self.unloaded.value

    def place_mm(self, dofs: np.ndarray | None = None) -> float:
        """Position along n at the gap from the present shape, or from that of a displacement."""
        along = self._along(self._u.x.array if dofs is None else dofs)
        nearest = self._least(float(along.min(initial=np.inf)))
        where_nothing_faces_it = 0.0
        nearest = nearest if np.isfinite(nearest) else where_nothing_faces_it
        return nearest - self._gap_mm - self.width_mm

    def nearest(self) -> np.ndarray:
        """This rank's points that are nearest to the plate at the present shape."""
        along = self._along(self._u.x.array)
        least = self._least(float(along.min(initial=np.inf)))
        return np.flatnonzero(along <= least + EQUAL_mm)

    def _along(self, dofs: np.ndarray) -> np.ndarray:
        """Positions of the nodes that may touch, along n (mm)."""
        return np.asarray(self.points.positions(dofs) @ self.normal)
