"""Forms are compiled and assembled, over all ranks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import numpy as np
import ufl
from dolfinx import fem, la
from mpi4py import MPI

from dolfingrip.mechanics.model import jit

COMPILED: Final = "dolfingrip: compiled"
"""Place of a compiled form in what UFL lets others keep with the form."""


def to_assemble(form: ufl.Form) -> fem.Form:
    """Compile a form, once, with the options of :mod:`dolfingrip.mechanics.model.jit`.

    Args:
        form: in UFL.
    """
    if COMPILED not in form._cache:
        form._cache[COMPILED] = fem.form(form, jit_options=jit.options())
    return form._cache[COMPILED]


def integral(form: ufl.Form) -> float:
    """Sum all ranks' parts of an integral.

    Args:
        form: without arguments; it is compiled when its integral is first asked for.
    """
    compiled = to_assemble(form)
    return float(compiled.mesh.comm.allreduce(fem.assemble_scalar(compiled), MPI.SUM))


def owned_vector(form: ufl.Form) -> np.ndarray:
    """Assemble a vector; ranks send the parts of their ghosts.

    Args:
        form: linear in its test function; it is compiled when it is first assembled.

    Returns:
        Its values at the dofs that this rank owns.
    """
    compiled = to_assemble(form)
    vector, dofs = fem.assemble_vector(compiled), compiled.function_spaces[0].dofmap
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
