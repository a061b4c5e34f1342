"""Values of an energy, and its derivatives by two numbers, for many sets of parameters at once.

UFL expressions describe an energy once for all. Here such an expression becomes numpy arrays
without a mesh and without a compiler. Each value is carried with its derivatives by two
numbers that are chosen (forward differentiation; Griewank & Walther, Evaluating Derivatives, 2008,
chapter 3).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Final, NamedTuple, cast

import basix.ufl
import numpy as np
import scipy.special
import ufl
from ufl import classes as node
from ufl.core.expr import Expr

SOLID = ufl.Mesh(basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,)))
"""Domain of expressions in coordinates, which UFL requires; it has no cells."""

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
    parts = np.zeros((*value.shape[:-1], PARTS, value.shape[-1]))
    parts[..., 0, :] = value
    return parts


def variable(value: Array, which: int) -> Array:
    """One of the two numbers itself.

    Args:
        value: (sets,).
        which: 0 or 1, its place among the derivatives.
    """
    parts = constant(value, by_set=True)
    parts[1 + which] = 1.0
    return parts


class Evaluation:
    """Expressions that are evaluated again and again with other values of their symbols.

    What depends only on symbols that are given the same array as in the last call is not computed
    anew.

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
        self._symbols: list[Expr] = []
        self._steps: list[_Step] = []
        places: dict[int, int] = {}
        same: dict[Hashable, int] = {}  # equal expressions are computed once
        wanted = [ufl.as_ufl(expr) for expr in expressions]
        left = [*wanted]
        while left:
            top = left[-1]
            if id(top) in places:
                left.pop()
                continue
            waiting = [part for part in _operands(top) if id(part) not in places]
            if waiting:
                left += waiting
                continue
            left.pop()
            places[id(top)] = self._place(top, [places[id(part)] for part in _operands(top)], same)
        self._wanted = [places[id(expr)] for expr in wanted]
        self._given: list[Array | None] = [None] * len(self._symbols)
        self._kept: list[Array | None] = [None] * len(self._steps)

    def _place(self, expr: Expr, operands: list[int], same: dict[Hashable, int]) -> int:
        """Where the value of an expression stands among the steps."""
        if isinstance(expr, node.Variable):
            return operands[0]
        indices = [part for part in expr.ufl_operands if isinstance(part, node.MultiIndex)]
        key: Hashable = (type(expr), *operands, *indices) if expr.ufl_operands else expr
        if key not in same:
            same[key] = len(self._steps)
            depends_on = 0
            for operand in operands:
                depends_on |= self._steps[operand].depends_on
            rule = _rule(expr)
            if rule is None:
                depends_on = 1 << len(self._symbols)
                self._symbols.append(expr)
            self._steps.append(_Step(rule, tuple(operands), depends_on))
        return same[key]

    def __call__(self, symbols: Mapping[Expr, Array]) -> list[Array]:
        """Values of the expressions.

        Args:
            symbols: value of each constant and coefficient, as :func:`constant` or
                :func:`variable` make them. A value that changes is another array.
        """
        changed = 0
        for i, symbol in enumerate(self._symbols):
            value = symbols[symbol]
            if value is not self._given[i]:
                self._given[i] = value
                changed |= 1 << i
        given, values = iter(self._given), self._kept
        for place, (rule, operands, depends_on) in enumerate(self._steps):
            if rule is None:
                values[place] = next(given)
            elif depends_on & changed or values[place] is None:
                values[place] = rule(*[values[operand] for operand in operands])
        wanted = [cast(Array, values[place]) for place in self._wanted]
        # what has changed once will change again, and need not fill memory meanwhile
        self._kept = [
            None if step.depends_on & changed else value
            for step, value in zip(self._steps, values, strict=True)
        ]
        return wanted


class _Step(NamedTuple):
    """How one value comes of others.

    Attributes:
        rule: of the operands' values; None for a symbol, whose value is given.
        operands: places of the steps before.
        depends_on: symbols, as the bits of a number.
    """

    rule: Callable[..., Array] | None
    operands: tuple[int, ...]
    depends_on: int


def _operands(expression: Expr) -> Sequence[Expr]:
    if isinstance(expression, node.Variable):
        return expression.ufl_operands[:1]
    return [part for part in expression.ufl_operands if not isinstance(part, node.MultiIndex)]


def _rule(expr: Expr) -> Callable[..., Array] | None:
    """How an expression's value comes of those of its operands; None of a symbol."""
    kind = type(expr)
    if kind in _SIMPLE:
        return _SIMPLE[kind]
    if isinstance(expr, node.ScalarValue):
        return _always(constant(float(expr)))
    if isinstance(expr, node.Zero):
        return _always(constant(np.zeros((*_free(expr).values(), *expr.ufl_shape))))
    if isinstance(expr, node.Identity):
        return _always(constant(np.eye(expr.ufl_shape[0])))
    if isinstance(expr, node.ListTensor):
        return _list_tensor(len(_free(expr)))
    if isinstance(expr, node.Indexed):
        return _indexed(expr)
    if isinstance(expr, node.ComponentTensor):
        return _component_tensor(expr)
    if isinstance(expr, node.IndexSum):
        (index,) = expr.ufl_operands[1].indices()
        axis = list(_free(expr.ufl_operands[0])).index(index.count())
        return lambda value: value.sum(axis=axis)
    if isinstance(expr, node.Product):
        return _product(expr)
    if isinstance(expr, node.Sum):
        return np.add
    if expr._ufl_is_terminal_:
        return None
    raise NotImplementedError(f"{kind.__name__}: no rule")


def _always(value: Array) -> Callable[[], Array]:
    return lambda: value


def _free(expr: Expr) -> dict[int, int]:
    """Sizes of the free indices by their numbers, in order."""
    return dict(zip(expr.ufl_free_indices, expr.ufl_index_dimensions, strict=True))


def _list_tensor(axis: int) -> Callable[..., Array]:
    """Components that differ in their number of sets alone, after the free indices."""

    def stacked(*parts: Array) -> Array:
        shape = parts[0].shape
        sets = max(part.shape[-1] for part in parts)
        made = np.empty((len(parts), *shape[:-1], sets))
        for i, part in enumerate(parts):
            made[i] = part
        return np.moveaxis(made, 0, axis)

    return stacked


def _indexed(expr: Expr) -> Callable[[Array], Array]:
    tensor, multi = expr.ufl_operands
    before = list(_free(tensor))
    letters = {count: 2 + place for place, count in enumerate(_free(expr))}
    axes: list[int] = [letters[count] for count in before]
    picks: list[int | slice] = [slice(None)] * len(before)
    for index in multi.indices():
        if isinstance(index, node.FixedIndex):
            picks.append(int(index))
        else:
            picks.append(slice(None))
            axes.append(letters[index.count()])
    at, order = tuple(picks), [*letters.values()]
    if len(axes) > len(order):  # a diagonal
        return lambda value: np.einsum(value[at], [*axes, 0, 1], [*order, 0, 1])
    moved = (*(axes.index(letter) for letter in order), len(order), len(order) + 1)
    return lambda value: value[at].transpose(moved)


def _component_tensor(expr: Expr) -> Callable[[Array], Array]:
    inner, multi = expr.ufl_operands
    before = list(_free(inner))
    bound = [index.count() for index in multi.indices()]
    order = [before.index(count) for count in before if count not in bound]
    order += [before.index(count) for count in bound]

    def transposed(value: Array) -> Array:
        return value.transpose(*order, *range(len(order), value.ndim))

    return transposed


def _product(expr: Expr) -> Callable[[Array, Array], Array]:
    free = list(_free(expr))
    left, right = (
        tuple(slice(None) if count in _free(part) else None for count in free)
        for part in expr.ufl_operands
    )
    return lambda a, b: _times(a[left], b[right])


def _times(a: Array, b: Array) -> Array:
    product = a[..., :1, :] * b
    product[..., 1:, :] += a[..., 1:, :] * b[..., :1, :]
    return product


def _through(value: Array, here: Array, slope: Array) -> Array:
    """A function of a value, by itself and its slope there, (…, sets) each."""
    composed = np.asarray(slope)[..., None, :] * value
    composed[..., 0, :] = here
    return composed


def _function(
    function: Callable[[Array], Array], slope: Callable[[Array], Array]
) -> Callable[[Array], Array]:
    return lambda a: _through(a, function(a[..., 0, :]), slope(a[..., 0, :]))


def _power(a: Array, b: Array) -> Array:
    base, exponent = a[..., 0, :], b[..., 0, :]
    here = base**exponent
    power = _through(a, here, exponent * base ** (exponent - 1))
    if b[..., 1:, :].any():
        power[..., 1:, :] += (here * np.log(base))[..., None, :] * b[..., 1:, :]
    return power


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


ROW, COLUMN = np.ix_([1, 2, 0], [1, 2, 0])
LAST_ROW, LAST_COLUMN = np.ix_([2, 0, 1], [2, 0, 1])


def _cofactors(a: Array) -> Array:
    """Cofactors of 3 × 3 matrices, (3, 3, sets)."""
    value = a[..., 0, :]
    cofactors: Array = value[ROW, COLUMN] * value[LAST_ROW, LAST_COLUMN]
    cofactors -= value[ROW, LAST_COLUMN] * value[LAST_ROW, COLUMN]
    return cofactors


def _inverse(a: Array) -> Array:
    cofactors = _cofactors(a)
    value = np.swapaxes(cofactors, 0, 1) / (cofactors[0] * a[0, :, 0]).sum(axis=0)
    matrix = np.moveaxis(value, -1, 0)
    slopes = -matrix @ np.moveaxis(a[..., 1:, :], (0, 1), (-2, -1)) @ matrix
    inverse = np.empty_like(a)
    inverse[..., 0, :] = value
    inverse[..., 1:, :] = np.moveaxis(slopes, (-2, -1), (0, 1))
    return inverse


def _determinant(a: Array) -> Array:
    cofactors = _cofactors(a)
    determinant: Array = (cofactors[..., None, :] * a).sum(axis=(0, 1))
    determinant[0] /= 3  # each row's expansion is the determinant
    return determinant


def _either(condition: Array, a: Array, b: Array) -> Array:
    return np.where(condition[..., :1, :] > 0, a, b)


def _compare(function: Callable[[Array, Array], Array]) -> Callable[[Array, Array], Array]:
    def compared(a: Array, b: Array) -> Array:
        return np.where(function(a[..., :1, :], b[..., :1, :]), 1.0, 0.0)

    return compared


_SIMPLE: Final[Mapping[type, Callable[..., Array]]] = {
    node.Division: _divide,
    node.Power: _power,
    node.Sqrt: _function(np.sqrt, lambda v: 0.5 / np.sqrt(v)),
    node.Exp: _function(np.exp, np.exp),
    node.Ln: _function(np.log, lambda v: 1 / v),
    node.Atan: _function(np.arctan, lambda v: 1 / (1 + v**2)),
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
