"""Deformed fields for ParaView, one step for each row of the result table."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
from dolfinx import fem, io, la

from dolfingrip.files import whole
from dolfingrip.forms.kinematics import deformation_gradient
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.model import Model

COLLECTION = """<?xml version="1.0"?>
<VTKFile type="Collection" version="1.0">
  <Collection>
{}
  </Collection>
</VTKFile>
"""


_ENDS = whole.ends_with(b"</VTKFile>")


class PrincipalStretch:
    """Largest principal stretch λ₁ = √(largest eigenvalue of C), the mean of elements at a node.

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


class FieldFile:
    """``fields.pvd`` with ``displacement_mm`` and ``principal_stretch`` at each step.

    Both are Lagrange functions of the displacement's order, so the displacement is exact.
    """

    def __init__(self, model: Model, path: Path) -> None:
        self._model = model
        self._path = path
        self._stretch = PrincipalStretch(model.u)
        space = model.u.function_space
        lagrange = ("Lagrange", space.ufl_element().degree, (3,))
        self._shown = fem.Function(fem.functionspace(space.mesh, lagrange), name=model.u.name)
        # The parts have the collection's stem. That of dolfinx is not written whole and lists no
        # step before it is closed, so it gets another name and is dropped.
        self._listed = path.with_suffix(".part")
        self._file = io.VTKFile(model.comm, str(self._listed), "w")
        self._steps: list[str] = []

    def write(self, time_s: float) -> None:
        """Append the present state; its time in the file is ``time_s``.

        Raises:
            WriteError: on all ranks, if one of them could not write its part.
        """
        self._stretch.update()
        self._shown.interpolate(self._model.u)
        self._file.write_function([self._shown, self._stretch.field], time_s)
        stem, step = self._path.stem, f"{len(self._steps):06d}"
        self._steps.append(
            f'    <DataSet timestep="{time_s:.10g}" part="0" file="{stem}{step}.pvtu" />'
        )
        comm = self._model.comm
        try:
            self._require(f"{stem}_p{comm.rank}_{step}.vtu")
            if comm.rank == 0:
                self._require(f"{stem}{step}.pvtu")
                whole.write(self._path, COLLECTION.format("\n".join(self._steps)))
            failure = None
        except whole.WriteError as error:
            failure = error
        for each in comm.allgather(failure):  # the other ranks would wait for one that ends
            if each is not None:
                raise each

    def _require(self, name: str) -> None:
        """Raise unless dolfinx, which tells no error, has written the whole of a file."""
        file = self._path.with_name(name)
        try:
            whole.require(file, file, _ENDS)
        except whole.WriteError:
            file.unlink(missing_ok=True)
            raise

    def close(self) -> None:
        """Finish the file, on all ranks."""
        with suppress(RuntimeError):  # the list of steps is not needed
            self._file.close()
        del self._file  # which writes the list again as it goes
        if self._model.comm.rank == 0:
            self._listed.unlink(missing_ok=True)
