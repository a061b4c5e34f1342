"""Deformed fields for ParaView, one step for each row of the result table."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from dolfinx import fem, plot
from dolfinx.fem.petsc import interpolation_matrix

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
<Piece NumberOfPoints="{{}}" NumberOfCells="{{}}">
{{}}</Piece></UnstructuredGrid>
<AppendedData encoding="raw">_"""
"""Readers turn two edges of Lagrange hexahedra in files of versions before 2.1."""

PIECE_END = b"\n</AppendedData></VTKFile>\n"

STEP = """<VTKFile type="PUnstructuredGrid" version="2.2"><PUnstructuredGrid GhostLevel="0">
<PPoints><PDataArray type="Float64" Name="Points" NumberOfComponents="3"/></PPoints>
<PPointData>
{}</PPointData>
{}</PUnstructuredGrid></VTKFile>
"""

TYPES = {"float64": "Float64", "int32": "Int32", "uint8": "UInt8"}
"""VTK's names of numpy's types."""


class FieldFile:
    """``fields.pvd`` with the displacement and all of ``channels.FIELDS`` at each step.

    They are Lagrange functions of the displacement's order, so the displacement is exact. Arrays
    are binary, appended to the XML; each rank writes its cells.

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
        self._to_nodes = interpolation_matrix(space, vector)
        self._to_nodes.assemble()
        self._moved = fem.Function(vector)
        self._mesh = _mesh(scalar)
        self._steps: list[str] = []

    def write(self, time_s: float) -> None:
        """Append the present state; its time in the file is ``time_s``.

        Raises:
            WriteError: on all ranks, if one of them could not write its part.
        """
        self._to_nodes.mult(self._model.u.x.petsc_vec, self._moved.x.petsc_vec)
        self._moved.x.scatter_forward()
        fields = {self._model.u.name: self._moved.x.array.reshape(-1, 3)}
        for computed in self._computed:
            fields |= computed.values()
        comm, stem, number = self._model.comm, self._path.stem, f"{len(self._steps):06d}"
        pieces = [f"{stem}_p{rank}_{number}.vtu" for rank in range(comm.size)]
        failure = None
        try:
            piece = _piece({**self._mesh, "PointData": fields})
            whole.write(self._path.with_name(pieces[comm.rank]), piece)
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


def _mesh(space: fem.FunctionSpace) -> dict[str, dict[str, np.ndarray]]:
    """Nodes and cells of this rank, by the sections of VTK's XML and the names of its arrays."""
    cells, kinds, points = plot.vtk_mesh(space)
    nodes = space.dofmap.dof_layout.num_dofs
    connectivity = cells.reshape(-1, nodes + 1)[:, 1:].astype(np.int32)
    ends = np.arange(1, len(kinds) + 1, dtype=np.int32) * nodes
    arrays = {"connectivity": connectivity.ravel(), "offsets": ends, "types": kinds.astype("u1")}
    return {"Points": {"Points": points}, "Cells": arrays}


def _piece(sections: Mapping[str, Mapping[str, np.ndarray]]) -> bytes:
    """The file of one rank: each section declares its arrays, whose bytes come at the end."""
    declared, blocks, offset = "", [], 0
    for section, arrays in sections.items():
        declared += f"<{section}>\n"
        for name, values in arrays.items():
            how = f'format="appended" offset="{offset}"'
            declared += f"<DataArray {_declared(name, values)} {how}/>\n"
            blocks += [np.uint64(values.nbytes).tobytes(), values.tobytes()]
            offset += 8 + values.nbytes
        declared += f"</{section}>\n"
    counts = len(sections["Points"]["Points"]), len(sections["Cells"]["types"])
    return b"".join([PIECE.format(*counts, declared).encode(), *blocks, PIECE_END])


def _declared(name: str, values: np.ndarray) -> str:
    """Name, type and entries of an array, as VTK's XML declares it."""
    entries = 1 if values.ndim == 1 else values.shape[1]
    return f'type="{TYPES[values.dtype.name]}" Name="{name}" NumberOfComponents="{entries}"'
