"""Methods that PETSc calls, without a reference by which PETSc would keep their owner alive.

PETSc holds its contexts and callbacks where Python's collector cannot see them. An owner of a PETSc
object that is also that object's context would never be freed, nor the model that it solves.
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any
from weakref import WeakMethod


def callback(method: Callable[..., Any]) -> Callable[..., Any]:
    """A function that calls ``method`` of an object, and does not keep the object alive."""
    weak = WeakMethod(method)

    def call(*arguments: Any) -> Any:
        alive = weak()
        assert alive is not None, "PETSc called a method of an object that is gone"
        return alive(*arguments)

    return call


def context(*methods: Callable[..., Any]) -> SimpleNamespace:
    """A context of PETSc's types ``python`` with these methods, each a :func:`callback`."""
    return SimpleNamespace(**{method.__name__: callback(method) for method in methods})
