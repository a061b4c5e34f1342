"""Deformed fields for ParaView, one step for each row of the result table."""

from __future__ import annotations

import base64
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from dolfinx import fem, plot

from dolfingrip.files import whole
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.readings import nodal_fields

COLLECTION = """<?xml version="1.0"?>
<VTKFile type="Collection" version="1.0">
  <Collection>
{}
  </Collection>
</VTKFile>
"""

PIECE = f"""<VTKFile type="UnstructuredGrid" version="2.2" header_type="UInt64" \
byte_order="{sys.byteorder.title()}Endian"><UnstructuredGrid>
{{}}</PointData></Piece></UnstructuredGrid></VTKFile>
"""
"""Readers turn two edges of Lagrange hexahedra in files of versions before 2.1."""

STEP = """<VTKFile type="PUnstructuredGrid" version="2.2"><PUnstructuredGrid GhostLevel="0">
<PPoints><PDataArray type="Float64" Name="Points" NumberOfComponents="3"/></PPoints>
<PPointData>
{}</PPointData>
{}</PUnstructuredGrid></VTKFile>
"""

TYPES = {"float64": "Float64", "int64": "Int64", "uint8": "UInt8"}
"""VTK's names of numpy's types."""


class FieldFile:
    """``fields.pvd`` with the displacement and all of ``channels.FIELDS`` at each step.

    They are Lagrange functions of the displacement's order, so the displacement is exact. Arrays
    are binary, in base64; each rank writes its cells.

    Args:
        model: of the specimen.
        path: of the collection.
        pressures: pressure (kPa) in each cavity by its name; without any, the field is left out.
    """

    def __init__(self, model: Model, path: Path, pressures: Mapping[str, Control]) -> None:
        self._model = model
        self._path = path
        space = model.u.function_space
        scalar, vector = (
            fem.functionspace(space.mesh, ("Lagrange", space.ufl_element().degree, shape))
            for shape in ((), (3,))
        )
        nodes = nodal_fields.Nodes(scalar)
        self._computed = (
            nodal_fields.PrincipalStretch(model.u, nodes),
            nodal_fields.Stress(model, nodes),
            nodal_fields.ContactPressure(model, nodes),
            nodal_fields.CavityPressure(pressures, model, nodes),
        )
        self._shown = fem.Function(vector)
        self._mesh = _mesh(scalar)
        self._steps: list[str] = []

    def write(self, time_s: float) -> None:
        """Append the present state; its time in the file is ``time_s``.

        Raises:
            WriteError: on all ranks, if one of them could not write its part.
        """
        self._shown.interpolate(self._model.u)
        fields = {self._model.u.name: self._shown.x.array.reshape(-1, 3)}
        for computed in self._computed:
            fields |= computed.values()
        comm, stem, number = self._model.comm, self._path.stem, f"{len(self._steps):06d}"
        pieces = [f"{stem}_p{rank}_{number}.vtu" for rank in range(comm.size)]
        failure = None
        try:
            arrays = "".join(_array(name, values) for name, values in fields.items())
            whole.write(self._path.with_name(pieces[comm.rank]), PIECE.format(self._mesh + arrays))
        except whole.WriteError as error:
            failure = error
        for problem in comm.allgather(failure):  # the other ranks would wait for one that ends
            if problem is not None:
                raise problem
        listed = f'    <DataSet timestep="{time_s:.10g}" part="0" file="{stem}{number}.pvtu" />'
        self._steps.append(listed)
        declared = (f"<PDataArray {_declared(*field)}/>\n" for field in fields.items())
        sources = (f'<Piece Source="{name}"/>\n' for name in pieces)
        contents = {
            f"{stem}{number}.pvtu": STEP.format("".join(declared), "".join(sources)),
            self._path.name: COLLECTION.format("\n".join(self._steps)),
        }
        files = {self._path.with_name(name): text for name, text in contents.items()}
        on_root(comm, lambda: whole.write_together(files))


def _mesh(space: fem.FunctionSpace) -> str:
    """Nodes and cells of this rank, up to the beginning of the fields."""
    cells, kinds, points = plot.vtk_mesh(space)
    nodes = space.dofmap.dof_layout.num_dofs
    connectivity = cells.reshape(-1, nodes + 1)[:, 1:].astype(np.int64)
    ends = np.arange(1, len(kinds) + 1, dtype=np.int64) * nodes
    return (
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(kinds)}">\n'
        f"<Points>\n{_array('Points', points)}</Points>\n"
        f"<Cells>\n{_array('connectivity', connectivity.ravel())}{_array('offsets', ends)}"
        f"{_array('types', kinds.astype(np.uint8))}</Cells>\n<PointData>\n"
    )


def _declared(name: str, values: np.ndarray) -> str:
    """Name, type and entries of an array, as VTK's XML declares it."""
    entries = 1 if values.ndim == 1 else values.shape[1]
    return f'type="{TYPES[values.dtype.name]}" Name="{name}" NumberOfComponents="{entries}"'


def _array(name: str, values: np.ndarray) -> str:
    """An array as VTK's XML has it: the number of its bytes and the bytes, in base64."""
    content = base64.b64encode(np.uint64(values.nbytes).tobytes() + values.tobytes()).decode()
    return f'<DataArray {_declared(name, values)} format="binary">{content}</DataArray>\n'
