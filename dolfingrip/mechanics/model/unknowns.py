"""The fields of a model as one vector."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from dolfinx import fem, la
from petsc4py import PETSc


class Unknowns:
    """Displacement, and the pressure field of a mixed model, in one array.

    Two layouts: a *local* array has all dofs that this rank knows, ghosts included, field after
    field; a PETSc vector has the owned ones, field after field on each rank. Of a displacement
    alone both are those of its function.

    Args:
        fields: displacement first.

    Attributes:
        count: unknowns on all ranks, of all fields.
    """

    def __init__(self, fields: Sequence[fem.Function]) -> None:
        self._fields = fields
        maps = [field.function_space.dofmap for field in fields]
        self._owned = [m.index_map.size_local * m.index_map_bs for m in maps]
        self.count = sum(m.index_map.size_global * m.index_map_bs for m in maps)
        ends = np.cumsum([0, *(len(field.x.array) for field in fields)])
        self._places = [slice(*pair) for pair in pairwise(ends)]

    def create_vector(self) -> PETSc.Vec:
        """A PETSc vector of the unknowns; with ghosts for a displacement alone."""
        if len(self._fields) == 1:
            dofmap = self._fields[0].function_space.dofmap
            return la.create_petsc_vector(dofmap.index_map, dofmap.index_map_bs)
        comm = self._fields[0].function_space.mesh.comm
        return PETSc.Vec().createMPI((sum(self._owned), self.count), comm=comm)

    def parts(self, local: np.ndarray) -> list[np.ndarray]:
        """Views of a local array, one a field."""
        return [local[place] for place in self._places]

    def local(self) -> np.ndarray:
        """A copy of the fields' values as a local array."""
        return np.concatenate([field.x.array for field in self._fields])

    def set_local(self, local: np.ndarray) -> None:
        """Set the fields to a local array."""
        for field, values in zip(self._fields, self.parts(local), strict=True):
            field.x.array[:] = values

    def owned(self) -> np.ndarray:
        """A copy of the fields' owned values, in the order of a vector."""
        pairs = zip(self._fields, self._owned, strict=True)
        return np.concatenate([field.x.array[:owned] for field, owned in pairs])

    def owned_part(self, local: np.ndarray) -> np.ndarray:
        """The owned values of a local array, in the order of a vector."""
        pairs = zip(self.parts(local), self._owned, strict=True)
        return np.concatenate([values[:owned] for values, owned in pairs])

    def set_owned(self, values: np.ndarray) -> None:
        """Set the fields to a vector's values, ghosts from their owners."""
        start = 0
        for field, owned in zip(self._fields, self._owned, strict=True):
            field.x.array[:owned] = values[start : start + owned]
            field.x.scatter_forward()
            start += owned

    def to_local(self, values: np.ndarray) -> np.ndarray:
        """A vector's values as a local array, ghosts from their owners."""
        kept = self.local()
        self.set_owned(values)
        local = self.local()
        self.set_local(kept)
        return local
