"""Coulomb friction where barrier contact holds surfaces apart."""

from __future__ import annotations

from collections.abc import Mapping

import ipctk
import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.surface import Surface


class FrictionalContact(BarrierContact):
    """Barrier contact whose surfaces rub: a memory of a model, as a load step starts somewhere.

    Π += Σ μ N f(|s|) over the pairs that were felt as the load step began, s the slip in it: the
    part of the pair's relative displacement in the tangent plane. Normal forces N, tangent planes
    and closest points are those of the step's start (lagged: Li, Ferguson, Schneider et al.,
    Incremental Potential Contact, ACM Trans. Graph. 39, 2020, sec. 5), so that friction has a
    potential and the tangent stays symmetric; the error is of the order of the load step, and a
    touch rubs from the step after it on. f' rises smoothly from 0 to 1, which it reaches at
    |s| = ε: below it friction is a spring's. The spring is at rest as a step begins, whatever
    friction there was before, so that surfaces that stick creep by up to ε in each step, also
    where the load rests.

    Args:
        surface: vertices and triangles of all bodies.
        width_mm: distance at which contact is first felt.
        stiffness_MPa: of the barrier.
        u: displacement (mm), whose present value is a load step's start.
        coefficient: μ.
        slip_mm: ε.
    """

    def __init__(
        self,
        surface: Surface,
        width_mm: float,
        stiffness_MPa: float,
        *,
        u: fem.Function,
        coefficient: float,
        slip_mm: float,
    ) -> None:
        super().__init__(surface, width_mm, stiffness_MPa)
        self._u = u
        self._coefficient = coefficient
        self._friction = ipctk.FrictionPotential(slip_mm)
        self.accept()

    def _slip(self, dofs: np.ndarray) -> np.ndarray:
        """(v, 3) displacement of the vertices since the load step's start (mm)."""
        return np.asfortranarray(self.positions(dofs) - self._before)

    # -- energy --------------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ), the same on all ranks; that of friction up to a constant of the step."""
        rubbed = self._friction(self._rubbing, self._mesh, self._slip(dofs))
        return super().value(dofs) + float(rubbed)

    def friction_N(self, dofs: np.ndarray) -> np.ndarray:
        """(n, 3) gradient (N) of the friction's part at the surface's nodes."""
        if self._rubbing.empty():
            return np.zeros((len(self.surface.nodes), 3))
        at_vertices = self._friction.gradient(self._rubbing, self._mesh, self._slip(dofs))
        return np.asarray(self.surface.weights.T @ at_vertices.reshape(-1, 3))

    def gradient(self, dofs: np.ndarray) -> np.ndarray:
        """(n, 3) gradient (N) at the surface's nodes."""
        return super().gradient(dofs) + self.friction_N(dofs)

    def hessian(self, dofs: np.ndarray, *, convex: bool = False) -> sp.coo_matrix | None:
        """(3n, 3n) Hessian (N/mm) at the nodes; None without contact. Friction's is convex."""
        normal = super().hessian(dofs, convex=convex)
        if self._rubbing.empty():
            return normal
        at_vertices = self._friction.hessian(self._rubbing, self._mesh, self._slip(dofs))
        rubbed = self._spread.T @ at_vertices @ self._spread
        return sp.coo_matrix(rubbed if normal is None else normal + rubbed)

    # -- as a memory ---------------------------------------------------------------------------

    def accept(self) -> None:
        """Take the present positions and normal forces for those of a load step's start."""
        self._before = self.positions(self._u.x.array)
        self._rubbing = ipctk.TangentialCollisions()
        self._rubbing.build(
            self._mesh, self._before, self._felt(self._before), self._potential, self._coefficient
        )

    def values(self) -> dict[str, np.ndarray]:
        """Nothing: all of it follows from the displacement, which is the state's own."""
        return {}

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Remember what a restored displacement implies."""
        self.accept()
