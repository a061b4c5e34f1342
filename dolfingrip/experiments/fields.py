"""Deformed fields for ParaView, one step for each row of the result table."""

from __future__ import annotations

from pathlib import Path

from dolfinx import io

from dolfingrip.experiments.stretch import PrincipalStretch
from dolfingrip.mechanics.model import Model


class FieldFile:
    """``fields.pvd`` with ``displacement_mm`` and ``principal_stretch`` at each step.

    Both are of the displacement's order, on Lagrange tetrahedra.
    """

    def __init__(self, model: Model, path: Path) -> None:
        self._model = model
        self._stretch = PrincipalStretch(model.u)
        self._file = io.VTKFile(model.comm, str(path), "w")

    def write(self) -> None:
        """Append the present state; its time is the model's."""
        self._stretch.update()
        self._file.write_function([self._model.u, self._stretch.field], self._model.time_s)

    def close(self) -> None:
        """Finish the file, on all ranks."""
        self._file.close()
