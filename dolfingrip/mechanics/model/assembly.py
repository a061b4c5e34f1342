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
    """Compile a form with the options of :mod:`dolfingrip.mechanics.model.jit`.

    Args:
        form: in UFL.
    """
    return fem.form(form, jit_options=jit.options())


def integral(form: fem.Form) -> float:
    """Sum all ranks' parts of an integral.

    Args:
        form: without arguments.
    """
    return float(form.mesh.comm.allreduce(fem.assemble_scalar(form), MPI.SUM))


def owned_vector(form: fem.Form) -> np.ndarray:
    """Assemble a vector; ranks send the parts of their ghosts.

    Args:
        form: linear in its test function.

    Returns:
        Its values at the dofs that this rank owns.
    """
    vector, dofs = fem.assemble_vector(form), form.function_spaces[0].dofmap
    vector.scatter_reverse(la.InsertMode.add)
    return np.asarray(vector.array[: dofs.index_map.size_local * dofs.index_map_bs])


def box(comm: MPI.Comm, points: np.ndarray) -> np.ndarray:
    """Find the box around points.

    Args:
        comm: their ranks.
        points: (n, 3) of this rank.

    Returns:
        (2, 3) least and largest coordinates of all ranks' points.
    """
    low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
    return np.array([comm.allreduce(low, np.minimum), comm.allreduce(high, np.maximum)])


@contextmanager
def undeformed(u: fem.Function) -> Iterator[None]:
    """Set a displacement to 0 in this context.

    Args:
        u: restored afterwards.
    """
    now = u.x.array.copy()
    u.x.array[:] = 0.0
    try:
        yield
    finally:
        u.x.array[:] = now
