"""Values of an energy, and its derivatives by two numbers, for many sets of parameters at once.

UFL expressions describe an energy once for all. Here such an expression becomes numpy arrays
without a mesh and without a compiler. Each value is carried with its derivatives by two
numbers that are chosen (forward differentiation; Griewank & Walther, Evaluating Derivatives, 2008,
chapter 3).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
import scipy.special
import ufl
from ufl import classes as node
from ufl.core.expr import Expr

from dolfingrip.forms.evaluate import SOLID

__all__ = ["SOLID", "Evaluation", "constant", "variable"]

Array = np.ndarray
"""Axes: free indices in the order of UFL, the tensor's axes, then 3 (the value and its
derivatives by the two numbers), then the sets of parameters."""

PARTS: Final = 3


def constant(value: Array | float, *, by_set: bool = False) -> Array:
    """A number or tensor that depends on neither of the two numbers.

    Args:
        value: of the tensor's shape, with an axis for the sets after it where ``by_set`` is true.
        by_set: whether each set has a value of its own.
    """
    value = np.asarray(value, dtype=float)
    if not by_set:
        value = value[..., None]
    found = np.zeros((*value.shape[:-1], PARTS, value.shape[-1]))
    found[..., 0, :] = value
    return found


def variable(value: Array, which: int) -> Array:
    """One of the two numbers itself.

    Args:
        value: (sets,).
        which: 0 or 1, its place among the derivatives.
    """
    found = constant(value, by_set=True)
    found[1 + which] = 1.0
    return found


class Evaluation:
    """Expressions that are evaluated again and again with other values of their symbols.

    Args:
        expressions: of constants, coefficients and fixed tensors; derivatives must be carried out.

    Example:
        x² y and its derivatives at x = 3, y = 2.

        >>> x, y = (ufl.Constant(SOLID) for _ in range(2))
        >>> at = {x: variable(np.array([3.0]), 0), y: variable(np.array([2.0]), 1)}
        >>> (found,) = Evaluation([x**2 * y])(at)
        >>> found[:, 0].tolist()
        [18.0, 12.0, 9.0]
    """

    def __init__(self, expressions: Sequence[Expr]) -> None:
        self._order: list[Expr] = []
        self._wanted = [ufl.as_ufl(each) for each in expressions]
        seen: set[int] = set()
        left = [*self._wanted]
        while left:
            top = left[-1]
            if id(top) in seen:
                left.pop()
                continue
            waiting = [part for part in _operands(top) if id(part) not in seen]
            if waiting:
                left += waiting
                continue
            left.pop()
            seen.add(id(top))
            self._order.append(top)

    def __call__(self, symbols: Mapping[Expr, Array]) -> list[Array]:
        """Values of the expressions.

        Args:
            symbols: value of each constant and coefficient, as :func:`constant` or
                :func:`variable` make them.
        """
        done: dict[int, Array] = {}
        for each in self._order:
            done[id(each)] = _value(each, done, symbols)
        return [done[id(each)] for each in self._wanted]


def _operands(expression: Expr) -> Sequence[Expr]:
    if isinstance(expression, node.Variable):
        return expression.ufl_operands[:1]
    return [part for part in expression.ufl_operands if not isinstance(part, node.MultiIndex)]


def _value(each: Expr, done: Mapping[int, Array], symbols: Mapping[Expr, Array]) -> Array:
    kind = type(each)
    if each._ufl_is_terminal_ and each in symbols:
        return symbols[each]
    parts = [done[id(part)] for part in _operands(each)]
    if kind in _SIMPLE:
        return _SIMPLE[kind](*parts)
    if isinstance(each, node.ScalarValue):
        return constant(float(each))
    if isinstance(each, node.Zero):
        return constant(np.zeros((*_free(each).values(), *each.ufl_shape)))
    if isinstance(each, node.Identity):
        return constant(np.eye(each.ufl_shape[0]))
    if isinstance(each, node.Variable):
        return parts[0]
    if isinstance(each, node.ListTensor):
        return np.stack(np.broadcast_arrays(*parts), axis=len(_free(each)))
    if isinstance(each, node.Indexed):
        return _indexed(each, parts[0])
    if isinstance(each, node.ComponentTensor):
        return _component_tensor(each, parts[0])
    if isinstance(each, node.IndexSum):
        (index,) = each.ufl_operands[1].indices()
        return parts[0].sum(axis=list(_free(each.ufl_operands[0])).index(index.count()))
    if isinstance(each, node.Product):
        return _product(each, *parts)
    if isinstance(each, node.Sum):
        return parts[0] + parts[1]
    raise NotImplementedError(f"{kind.__name__}: no rule")


def _free(each: Expr) -> dict[int, int]:
    """Sizes of the free indices by their numbers, in order."""
    return dict(zip(each.ufl_free_indices, each.ufl_index_dimensions, strict=True))


def _indexed(each: Expr, value: Array) -> Array:
    tensor, multi = each.ufl_operands
    before = list(_free(tensor))
    letters = {count: 2 + place for place, count in enumerate(_free(each))}
    axes: list[int] = [letters[count] for count in before]
    at: list[int | slice] = [slice(None)] * len(before)
    for index in multi.indices():
        if isinstance(index, node.FixedIndex):
            at.append(int(index))
        else:
            at.append(slice(None))
            axes.append(letters[index.count()])
    picked = value[tuple(at)]
    return np.einsum(picked, [*axes, 0, 1], [*letters.values(), 0, 1])


def _component_tensor(each: Expr, value: Array) -> Array:
    inner, multi = each.ufl_operands
    before = list(_free(inner))
    bound = [index.count() for index in multi.indices()]
    order = [count for count in before if count not in bound] + bound
    return np.moveaxis(value, [before.index(count) for count in order], range(len(order)))


def _product(each: Expr, a: Array, b: Array) -> Array:
    free = list(_free(each))
    return _times(*(
        _spread(value, list(_free(part)), free)
        for part, value in zip(each.ufl_operands, (a, b), strict=True)
    ))  # fmt: skip


def _spread(value: Array, own: list[int], all_free: list[int]) -> Array:
    shape = iter(value.shape[: len(own)])
    sizes = [next(shape) if count in own else 1 for count in all_free]
    return value.reshape(*sizes, *value.shape[len(own) :])


def _times(a: Array, b: Array) -> Array:
    found = a[..., :1, :] * b
    found[..., 1:, :] += a[..., 1:, :] * b[..., :1, :]
    return found


def _through(value: Array, here: Array, slope: Array) -> Array:
    """A function of a value, by itself and its slope there, (…, sets) each."""
    found = np.asarray(slope)[..., None, :] * value
    found[..., 0, :] = here
    return found


def _function(
    function: Callable[[Array], Array], slope: Callable[[Array], Array]
) -> Callable[[Array], Array]:
    return lambda a: _through(a, function(a[..., 0, :]), slope(a[..., 0, :]))


def _power(a: Array, b: Array) -> Array:
    base, exponent = a[..., 0, :], b[..., 0, :]
    here = base**exponent
    found = _through(a, here, exponent * base ** (exponent - 1))
    if b[..., 1:, :].any():
        found[..., 1:, :] += (here * np.log(base))[..., None, :] * b[..., 1:, :]
    return found


def _divide(a: Array, b: Array) -> Array:
    return _times(a, _through(b, 1 / b[..., 0, :], -1 / b[..., 0, :] ** 2))


def _inner(a: Array, b: Array) -> Array:
    axes = tuple(range(a.ndim - 2))
    return _times(a, b).sum(axis=axes)


def _dot(a: Array, b: Array) -> Array:
    left = a.reshape(*a.shape[:-2], *(1,) * (b.ndim - 3), *a.shape[-2:])
    axis = a.ndim - 3
    return _times(left, b).sum(axis=axis)


def _trace(a: Array) -> Array:
    return np.einsum("iipn->pn", a)


def _matrices(a: Array) -> Array:
    return np.moveaxis(a, (0, 1), (-2, -1))


def _inverse(a: Array) -> Array:
    told = _matrices(a)
    value = np.linalg.inv(told[0])
    found = np.stack([value, *(-value @ told[k] @ value for k in (1, 2))])
    return np.moveaxis(found, (-2, -1), (0, 1))


def _determinant(a: Array) -> Array:
    told = _matrices(a)
    value = np.linalg.det(told[0])
    inverse = np.linalg.inv(told[0])
    slopes = [value * np.einsum("nij,nji->n", inverse, told[k]) for k in (1, 2)]
    return np.stack(np.broadcast_arrays(value, *slopes))


def _either(condition: Array, a: Array, b: Array) -> Array:
    a, b = np.broadcast_arrays(a, b)
    return np.where(condition[..., :1, :] > 0, a, b)


def _compare(function: Callable[[Array, Array], Array]) -> Callable[[Array, Array], Array]:
    def found(a: Array, b: Array) -> Array:
        return np.where(function(a[..., :1, :], b[..., :1, :]), 1.0, 0.0)

    return found


_SIMPLE: Final[Mapping[type, Callable[..., Array]]] = {
    node.Division: _divide,
    node.Power: _power,
    node.Sqrt: _function(np.sqrt, lambda v: 0.5 / np.sqrt(v)),
    node.Exp: _function(np.exp, np.exp),
    node.Ln: _function(np.log, lambda v: 1 / v),
    node.Sin: _function(np.sin, np.cos),
    node.Cos: _function(np.cos, lambda v: -np.sin(v)),
    node.Acos: _function(np.arccos, lambda v: -1 / np.sqrt(1 - v**2)),
    node.Erf: _function(scipy.special.erf, lambda v: 2 / np.sqrt(np.pi) * np.exp(-(v**2))),
    node.Abs: _function(np.abs, np.sign),
    node.MaxValue: lambda a, b: _either(_compare(np.greater_equal)(a, b), a, b),
    node.MinValue: lambda a, b: _either(_compare(np.less_equal)(a, b), a, b),
    node.LT: _compare(np.less),
    node.LE: _compare(np.less_equal),
    node.GT: _compare(np.greater),
    node.GE: _compare(np.greater_equal),
    node.EQ: _compare(np.equal),
    node.AndCondition: lambda a, b: a * b,
    node.OrCondition: np.maximum,
    node.NotCondition: lambda a: 1.0 - a,
    node.Conditional: _either,
    node.Inner: _inner,
    node.Dot: _dot,
    node.Trace: _trace,
    node.Inverse: _inverse,
    node.Determinant: _determinant,
    node.Conj: lambda a: a,
    node.Transposed: lambda a: np.swapaxes(a, 0, 1),
}
