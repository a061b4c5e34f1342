"""Forms are compiled and assembled, over all ranks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import ufl
from dolfinx import fem, la
from mpi4py import MPI

from dolfingrip.mechanics.model import jit


def to_assemble(form: ufl.Form) -> fem.Form:
    """The form, compiled with the options of :mod:`dolfingrip.mechanics.model.jit`."""
    return fem.form(form, jit_options=jit.options())


def integral(form: fem.Form) -> float:
    """The form's number, on every rank."""
    return float(form.mesh.comm.allreduce(fem.assemble_scalar(form), MPI.SUM))


def owned_vector(form: fem.Form) -> np.ndarray:
    """The form's vector at the dofs that this rank owns; ranks send the parts of their ghosts."""
    vector, dofs = fem.assemble_vector(form), form.function_spaces[0].dofmap
    vector.scatter_reverse(la.InsertMode.add)
    return np.asarray(vector.array[: dofs.index_map.size_local * dofs.index_map_bs])


def box(comm: MPI.Comm, points: np.ndarray) -> np.ndarray:
    """(2, 3) least and largest coordinates of all ranks' points (n, 3)."""
    low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
    return np.array([comm.allreduce(low, np.minimum), comm.allreduce(high, np.maximum)])


@contextmanager
def undeformed(u: fem.Function) -> Iterator[None]:
    """A context in which the displacement is 0; it is restored afterwards."""
    now = u.x.array.copy()
    u.x.array[:] = 0.0
    try:
        yield
    finally:
        u.x.array[:] = now
