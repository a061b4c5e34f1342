"""Derivatives of energies that hold functions whose own derivatives are known.

:mod:`dolfingrip.forms.isotropic` marks such functions. If UFL differentiates an expression by the
strain, it carries a tensor through each operation: nine numbers in the stress, 81 in its
derivative. The chain rule uses the known derivatives of marked functions instead. UFL
differentiates the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import basix.ufl
import ufl
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.classes import Label, Variable, Zero
from ufl.core.expr import Expr
from ufl.domain import extract_unique_domain

NOWHERE = ufl.Mesh(basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,)))
"""Domain of an expression that consists of numbers and so has no domain."""


class KnownDerivatives(Label):
    """Label of a value whose derivatives are known or are not asked for.

    Attributes:
        strain: Green–Lagrange strain E that the value is a function of, (3, 3).
        slope: derivative of the value by E; for energies only.
        rate: a function that returns the value's change for a change of E, of the value's shape.
    """

    def __init__(
        self,
        strain: Expr,
        slope: Expr | None = None,
        rate: Callable[[Expr], Expr] | None = None,
    ) -> None:
        super().__init__()
        self.strain, self.slope, self.rate = strain, slope, rate


class Strain(Label):
    """Label of the strain that energies are functions of.

    Attributes:
        shared: what several energies compute of the strain, by name. Each is computed once, so that
            equal expressions are the same object: UFL compares equal ones node by node otherwise,
            which takes for ever if each node is used twice by the next.
    """

    def __init__(self) -> None:
        super().__init__()
        self.shared: dict[str, Any] = {}


def strain_variable(strain: Expr) -> Variable:
    """Label a strain as the variable of energies.

    Args:
        strain: Green–Lagrange strain, (3, 3).

    Returns:
        The strain with a label; energies of the same label share work.
    """
    return Variable(strain, Strain())


def once[T](strain: Expr, name: str, compute: Callable[[], T]) -> T:
    """Compute a quantity of a strain, once for a strain that is shared."""
    label = strain.label() if isinstance(strain, Variable) else None
    if not isinstance(label, Strain):
        return compute()
    if name not in label.shared:
        label.shared[name] = compute()
    shared: T = label.shared[name]
    return shared


def by_variable(density: Expr, variable: Expr) -> Expr:
    """Derivative of a scalar by a variable, of the variable's shape.

    Args:
        density: a function of the strain.
        variable: the strain, or a number that the density depends on.

    Example:
        The marked function E₀₀² at E₀₀ = 3.

        >>> from dolfingrip.forms.evaluate import number
        >>> x = ufl.variable(ufl.as_ufl(3.0))
        >>> strain = ufl.as_matrix([[x, 0, 0], [0, 0, 0], [0, 0, 0]])
        >>> slope = ufl.as_matrix([[6, 0, 0], [0, 0, 0], [0, 0, 0]])
        >>> number(by_variable(2 * Variable(ufl.as_ufl(9.0), KnownDerivatives(strain, slope)), x))
        12.0
    """
    held, back = _held(density)
    if not back:
        return ufl.diff(density, variable)
    derivative = ufl.replace(_expanded(ufl.diff(held, variable)), back)
    for place, mark in back.items():
        label, one = mark.label(), ufl.variable(place)
        if label.slope is None:
            continue
        slope = label.slope
        if label.strain is not variable:
            slope = _through(slope, label.strain, variable)
        share = _expanded(ufl.diff(ufl.replace(held, {place: one}), one))
        derivative += ufl.replace(share, {one: mark, **back}) * slope
    return derivative


def _through(slope: Expr, strain: Expr, variable: Expr) -> Expr:
    """The slope by a variable of a function of ``strain``, which has ``slope`` by that strain."""
    rate = _expanded(ufl.diff(strain, variable))
    if not variable.ufl_shape:
        return ufl.inner(slope, rate)
    i, j, k, m = ufl.indices(4)
    return ufl.as_tensor(slope[k, m] * rate[k, m, i, j], (i, j))


def along(stress: Expr, field: Expr, way: Expr) -> Expr:
    """Derivative of an expression by a field in a direction.

    Args:
        stress: any expression of the field.
        field: function that the derivative is taken by.
        way: direction, of the field's shape.

    Returns:
        The derivative, of the expression's shape.
    """
    held, back = _held(stress)
    if not back:
        return ufl.derivative(stress, field, way)
    derivative = ufl.replace(_expanded(ufl.derivative(held, field, way)), back)
    rates: dict[Expr, Expr] = {}
    for place, mark in back.items():
        label = mark.label()
        if label.rate is None:
            continue
        if label.strain not in rates:
            rates[label.strain] = _expanded(ufl.derivative(label.strain, field, way))
        strain_rate = rates[label.strain]
        if not isinstance(strain_rate, Zero):
            change, within = _held(label.rate(strain_rate))
            share = _expanded(ufl.derivative(held, place, change))
            derivative += ufl.replace(share, {**back, **within})
    return derivative


def _marks(expression: Expr) -> Sequence[Variable]:
    """The marked functions in an expression, each once, without those inside them."""
    marks: dict[int, Variable] = {}
    seen: set[int] = set()
    left = [expression]
    while left:
        node = left.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        if isinstance(node, Variable) and isinstance(node.label(), KnownDerivatives):
            marks[node.label().count()] = node
        else:
            left.extend(node.ufl_operands)
    return [marks[count] for count in sorted(marks)]


def _held(expression: Expr) -> tuple[Expr, dict[Expr, Variable]]:
    """``expression`` with a placeholder instead of each mark, and the marked functions.

    Marked functions are never rebuilt. UFL compares equal expressions that are not the same object
    node by node, and that takes for ever if each node is used twice by the next.
    """
    marks = _marks(expression)
    if not marks:
        return expression, {}
    domain = extract_unique_domain(expression) or NOWHERE
    cell = str(domain.ufl_cell())
    places = []
    for mark in marks:
        shape = mark.ufl_shape
        element = basix.ufl.element("DG", cell, 0, **({"shape": shape} if shape else {}))
        places.append(ufl.Coefficient(ufl.FunctionSpace(domain, element)))
    held = ufl.replace(expression, dict(zip(marks, places, strict=True)))
    return held, dict(zip(places, marks, strict=True))


def _expanded(expression: Expr) -> Expr:
    return apply_derivatives(apply_algebra_lowering(expression))
