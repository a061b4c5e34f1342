"""The fields and global unknowns of a model as one vector."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from dolfinx import fem
from petsc4py import PETSc

NODE = 3
"""Numbers that share a block of the tangent matrix, as the components of a displacement do."""


class GlobalUnknown:
    """A number that is solved for with the displacement, such as a plate's position, a multiplier.

    The vector of unknowns has ``value / scale``, so that derivatives by it are forces (N).

    Args:
        name: name with its unit, such as ``plate_compliance.place_mm``.
        constant: constant with the present value; forms may contain it.
        scale: unit of the name for each mm of the unknown.
        multiplier: Π is concave in it: the solution is a saddle point, not a minimum.

    Attributes:
        place: of the unknown in a local array, once a model has it.
        index: its place among the model's global unknowns.
        node, component: its row of the tangent matrix, as those of a displacement are numbered.
    """

    def __init__(
        self, name: str, constant: fem.Constant, scale: float = 1.0, *, multiplier: bool = False
    ) -> None:
        self.name = name
        self.constant = constant
        self.scale = scale
        self.multiplier = multiplier
        self.place = self.index = self.node = self.component = -1

    @property
    def value(self) -> float:
        """Present value, in the unit of its name."""
        return float(self.constant.value)

    def change(self, step: np.ndarray) -> float:
        """By how much ``step``, a local array of the unknowns, changes the value."""
        return self.scale * float(step[self.place])


class Unknowns:
    """Displacement, the pressure field of a mixed model, and global unknowns, in one array.

    Two layouts: a *local* array has all dofs that this rank knows, ghosts included, field after
    field, then the global unknowns, which all ranks know. A PETSc vector has the owned ones, field
    after field on each rank; the last rank owns the global unknowns. These are filled up to whole
    blocks of three with entries that stay 0. Of a displacement alone both layouts are those of its
    function.

    Args:
        fields: displacement first.
        global_unknowns: solved for, too.

    Attributes:
        fields: as given.
        count: unknowns on all ranks, without what fills blocks up.
        size: length of a vector of them.
        padded: entries of the global unknowns, filled up.
    """

    def __init__(
        self, fields: Sequence[fem.Function], global_unknowns: Sequence[GlobalUnknown] = ()
    ) -> None:
        self.fields = fields
        self.global_unknowns = tuple(global_unknowns)
        space = fields[0].function_space
        self.comm = space.mesh.comm
        self.nodes = space.dofmap.index_map.size_global
        maps = [field.function_space.dofmap for field in fields]
        self._owned = [m.index_map.size_local * m.index_map_bs for m in maps]
        fields_count = sum(m.index_map.size_global * m.index_map_bs for m in maps)
        self.padded = NODE * -(-len(self.global_unknowns) // NODE)
        self.count = fields_count + len(self.global_unknowns)
        self.size = fields_count + self.padded
        ends = np.cumsum([0, *(len(field.x.array) for field in fields)])
        self._places = [slice(*pair) for pair in pairwise(ends)]
        self._local = int(ends[-1])
        for i, unknown in enumerate(self.global_unknowns):
            unknown.place, unknown.index = self._local + i, i
            unknown.node, unknown.component = self.nodes + i // NODE, i % NODE
        self.owns_globals = self.comm.rank == self.comm.size - 1 and self.padded > 0
        self.owned_size = sum(self._owned) + (self.padded if self.owns_globals else 0)

    def create_vector(self) -> PETSc.Vec:
        """A PETSc vector of the unknowns; with ghosts for a displacement alone."""
        if len(self.fields) == 1 and not self.padded:
            dofmap = self.fields[0].function_space.dofmap
            index, block = dofmap.index_map, dofmap.index_map_bs
            size = (block * index.size_local, block * index.size_global)
            ghosts = index.ghosts.astype(PETSc.IntType)
            return PETSc.Vec().createGhost(ghosts, size=size, bsize=block, comm=self.comm)
        return PETSc.Vec().createMPI((self.owned_size, self.size), bsize=1, comm=self.comm)

    # -- places ----------------------------------------------------------------------------------

    def parts(self, local: np.ndarray) -> list[np.ndarray]:
        """Views of a local array, one a field."""
        return [local[place] for place in self._places]

    def owned_parts(self, owned: np.ndarray) -> list[np.ndarray]:
        """Views of an owned array, one a field."""
        ends = np.cumsum([0, *self._owned])
        return [owned[start:end] for start, end in pairwise(ends)]

    def global_rows(self, owned: np.ndarray) -> np.ndarray:
        """View of an owned array's global unknowns, filled up; empty but on the last rank."""
        return owned[sum(self._owned) :]

    def global_nodes(self) -> np.ndarray:
        """Block numbers of the global unknowns in the tangent matrix of a displacement."""
        return self.nodes + np.arange(self.padded // NODE)

    # -- values ----------------------------------------------------------------------------------

    def _global_values(self) -> np.ndarray:
        values = np.zeros(self.padded)
        values[: len(self.global_unknowns)] = [n.value / n.scale for n in self.global_unknowns]
        return values

    def _set_global_values(self, values: np.ndarray) -> None:
        for unknown, value in zip(self.global_unknowns, values, strict=False):
            unknown.constant.value = float(value) * unknown.scale

    def local(self) -> np.ndarray:
        """A copy of the values as a local array."""
        return np.concatenate([*(field.x.array for field in self.fields), self._global_values()])

    def set_local(self, local: np.ndarray) -> None:
        """Set fields and global unknowns to a local array."""
        for field, values in zip(self.fields, self.parts(local), strict=True):
            field.x.array[:] = values
        self._set_global_values(local[self._local :])

    def owned(self) -> np.ndarray:
        """A copy of the owned values, in the order of a vector."""
        return self.owned_part(self.local())

    def owned_part(self, local: np.ndarray) -> np.ndarray:
        """The owned values of a local array, in the order of a vector."""
        pairs = zip(self.parts(local), self._owned, strict=True)
        fields = [values[:owned] for values, owned in pairs]
        return np.concatenate([*fields, local[self._local :] if self.owns_globals else []])

    def set_owned(self, values: np.ndarray) -> None:
        """Set fields and global unknowns to a vector's values; ghosts are updated."""
        for field, part in zip(self.fields, self.owned_parts(values), strict=True):
            field.x.array[: len(part)] = part
            field.x.scatter_forward()
        if self.padded:
            global_values = self.global_rows(values).copy() if self.owns_globals else None
            self._set_global_values(self.comm.bcast(global_values, root=self.comm.size - 1))

    def to_local(self, values: np.ndarray) -> np.ndarray:
        """A vector's values as a local array, ghosts from their owners."""
        kept = self.local()
        self.set_owned(values)
        local = self.local()
        self.set_local(kept)
        return local


class Gradient:
    """Derivatives of Π by this rank's owned unknowns (N), which terms add to.

    Args:
        unknowns: of the model.

    Attributes:
        array: in the order of a vector of the unknowns.
        fields: views of it, one a field.
    """

    def __init__(self, unknowns: Unknowns) -> None:
        self.array = np.zeros(unknowns.owned_size)
        self.fields = unknowns.owned_parts(self.array)
        self._rows = unknowns.global_rows(self.array)

    @property
    def at_nodes(self) -> np.ndarray:
        """View of the derivatives by the displacement of the owned nodes, (n, 3)."""
        return self.fields[0].reshape(-1, 3)

    def add(self, unknown: GlobalUnknown, slope: float) -> None:
        """Add dΠ/d(value of ``unknown``), the same on all ranks."""
        if len(self._rows):
            self._rows[unknown.index] += unknown.scale * slope
