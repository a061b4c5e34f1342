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


def context(*methods: Callable[..., Any]) -> SimpleNamespace:
    """Make a context of PETSc's types ``python`` with these methods, each a :func:`callback`."""
    return SimpleNamespace(**{method.__name__: callback(method) for method in methods})
