"""Methods as callbacks that do not keep their owner alive.

PETSc holds its contexts and callbacks where Python's collector cannot see them. An owner of a PETSc
object that is also that object's context would never be freed, nor the model that it solves. A
circle within Python would be freed, but only at the collector's next search.
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any
from weakref import WeakMethod

from mpi4py import MPI
from petsc4py import PETSc


def callback(method: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a method in a function that does not keep the method's object alive.

    Args:
        method: a bound method; its object lives as long as the function is called.

    Returns:
        A function of the same positional arguments.
    """
    weak = WeakMethod(method)

    def call(*arguments: Any) -> Any:
        alive = weak()
        assert alive is not None, "a method was called whose object is gone"
        return alive(*arguments)

    return call


def context(method: Callable[..., Any]) -> SimpleNamespace:
    """Make a context of PETSc's types ``python`` with this method, a :func:`callback`."""
    return SimpleNamespace(**{method.__name__: callback(method)})


def preconditioner(comm: MPI.Comm, apply: Callable[..., Any]) -> PETSc.PC:
    """Make a preconditioner that applies a method of its owner.

    Args:
        comm: ranks.
        apply: takes the preconditioner, a right-hand side, and the vector of the solution.
    """
    pc = PETSc.PC().create(comm)
    pc.setType(PETSc.PC.Type.PYTHON)
    pc.setPythonContext(context(apply))
    return pc
