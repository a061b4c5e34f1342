"""Deformed fields for ParaView, one step for each row of the result table."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from dolfinx import fem, io

from dolfingrip.files import whole
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.readings.nodal_fields import (
    CavityPressure,
    ContactPressure,
    Nodes,
    PrincipalStretch,
    Stress,
)

COLLECTION = """<?xml version="1.0"?>
<VTKFile type="Collection" version="1.0">
  <Collection>
{}
  </Collection>
</VTKFile>
"""


_ENDS = whole.ends_with(b"</VTKFile>")


class FieldFile:
    """``fields.pvd`` with the displacement and all of ``channels.FIELDS`` at each step.

    They are Lagrange functions of the displacement's order, so the displacement is exact.

    Args:
        model: of the specimen.
        path: of the collection.
        pressures: pressure (kPa) in each cavity by its name; without any, the field is left out.
    """

    def __init__(self, model: Model, path: Path, pressures: Mapping[str, Control]) -> None:
        self._model = model
        self._path = path
        space = model.u.function_space
        scalar = fem.functionspace(space.mesh, ("Lagrange", space.ufl_element().degree))
        nodes = Nodes(scalar)
        self._computed = (
            PrincipalStretch(model.u, nodes), Stress(model, nodes), ContactPressure(model, nodes),
            CavityPressure(pressures, model, nodes),
        )  # fmt: skip
        self._fields: dict[str, fem.Function] = {}
        self._scalar = scalar
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
        for computed in self._computed:
            for name, values in computed.values().items():
                field = self._fields.setdefault(name, fem.Function(self._scalar, name=name))
                field.x.array[:] = values
        self._shown.interpolate(self._model.u)
        self._file.write_function([self._shown, *self._fields.values()], time_s)
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
