"""Largest principal stretch at the displacement nodes."""

from __future__ import annotations

import numpy as np
from dolfinx import fem, la

from dolfingrip.forms.kinematics import deformation_gradient
from dolfingrip.mechanics.model import jit


class PrincipalStretch:
    """λ₁ = √(largest eigenvalue of C), averaged over the elements that share a node.

    Attributes:
        field: scalar Lagrange function of the displacement's order (–).
    """

    def __init__(self, u: fem.Function) -> None:
        space = u.function_space
        mesh = space.mesh
        degree = space.ufl_element().degree
        scalar = fem.functionspace(mesh, ("Lagrange", degree))
        self.field = fem.Function(scalar, name="principal_stretch")
        f = deformation_gradient(u)
        points = scalar.element.basix_element.points
        self._strain = fem.Expression(f.T * f, points, jit_options=jit.options())
        self._cells = np.arange(mesh.topology.index_map(3).size_local, dtype=np.int32)
        self._dofs = scalar.dofmap.list[self._cells]
        self._shared = fem.Function(scalar)
        self._gather(self._shared, np.ones(self._dofs.shape))

    def _gather(self, target: fem.Function, values: np.ndarray) -> None:
        """Sum element-wise nodal ``values`` into ``target``, over all ranks."""
        target.x.array[:] = 0.0
        np.add.at(target.x.array, self._dofs, values)
        target.x.scatter_reverse(la.InsertMode.add)
        target.x.scatter_forward()

    def update(self) -> None:
        """Evaluate at the present displacement."""
        mesh = self.field.function_space.mesh
        c = self._strain.eval(mesh, self._cells).reshape(*self._dofs.shape, 3, 3)
        largest = np.sqrt(np.linalg.eigvalsh(c)[..., -1])
        self._gather(self.field, largest)
        self.field.x.array[:] /= self._shared.x.array
