"""Deformed fields for ParaView, one step for each row of the result table."""

from __future__ import annotations

from pathlib import Path

from dolfinx import fem, io

from dolfingrip.experiments.results.stretch import PrincipalStretch
from dolfingrip.mechanics.model.model import Model

COLLECTION = """<?xml version="1.0"?>
<VTKFile type="Collection" version="1.0">
  <Collection>
{}
  </Collection>
</VTKFile>
"""


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
        self._file = io.VTKFile(model.comm, str(path), "w")
        self._steps: list[str] = []

    def write(self, time_s: float) -> None:
        """Append the present state; its time in the file is ``time_s``."""
        self._stretch.update()
        self._shown.interpolate(self._model.u)
        self._file.write_function([self._shown, self._stretch.field], time_s)
        piece = f"{self._path.stem}{len(self._steps):06d}.pvtu"
        self._steps.append(f'    <DataSet timestep="{time_s:.10g}" part="0" file="{piece}" />')
        if self._model.comm.rank == 0:
            # dolfinx lists the steps when it closes the file, which a killed run never does
            self._path.write_text(COLLECTION.format("\n".join(self._steps)), encoding="utf-8")

    def close(self) -> None:
        """Finish the file, on all ranks."""
        self._file.close()
