"""Moves the reference mesh along a velocity, in place, and puts it back."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import basix.ufl
import numpy as np
from dolfinx import fem

from dolfingrip.mechanics.model.compatibility import points_of_cells
from dolfingrip.mechanics.model.model import Model


class Movement:
    """Moves a model's reference configuration along a velocity; nodal displacements stay.

    Args:
        model: model whose mesh is moved and whose terms are updated.
        velocity: (n, 3) velocity of this rank's mesh points (mm for each unit of a parameter).
        measures: functions that are called after each motion of the mesh.
    """

    def __init__(
        self,
        model: Model,
        velocity: np.ndarray,
        measures: Sequence[Callable[[], None]] = (),
    ) -> None:
        self._measures = measures
        self._model = model
        self._geometry = model.domain.mesh.geometry
        self._velocity = velocity
        self._rest = self._geometry.x.copy()
        self._nodal = self._at_nodes(velocity)

    def _at_nodes(self, velocity: np.ndarray) -> np.ndarray:
        """Local array of the displacement's nodes, three components each."""
        mesh = self._model.domain.mesh
        element = basix.ufl.element("Lagrange", mesh.topology.cell_name(), 1, shape=(3,))
        space = fem.functionspace(mesh, element)
        field = fem.Function(space)
        corners = space.dofmap.list.shape[1]
        at = velocity[points_of_cells(self._geometry)[:, :corners]]
        field.x.array.reshape(-1, 3)[space.dofmap.list] = at
        moving = fem.Function(self._model.u.function_space)
        moving.interpolate(field)
        return np.asarray(moving.x.array)

    def move(self, amount: float) -> None:
        """Move the reference points to their places after ``amount`` of the parameter."""
        self._geometry.x[:] = self._rest + amount * self._velocity
        for measure in self._measures:
            measure()
        self._model.move_reference(amount * self._nodal if amount else None)
