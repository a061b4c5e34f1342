"""Fields at the integration points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import basix
import basix.ufl
import numpy as np
from dolfinx import fem, mesh
from ufl.classes import Label
from ufl.core.expr import Expr
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction

from dolfingrip.mechanics.model import jit


@dataclass(frozen=True, eq=False)
class Rule:
    """An integration rule that is not a standard one, such as points on a face of a cell.

    Attributes:
        points: (n, 3) reference coordinates.
        weights: (n,) weights.
    """

    points: np.ndarray
    weights: np.ndarray

    def metadata(self) -> dict[str, object]:
        """Metadata for a measure of UFL."""
        return {
            "quadrature_rule": "custom",
            "quadrature_points": self.points.tolist(),
            "quadrature_weights": self.weights.tolist(),
        }


def field(domain: mesh.Mesh, shape: tuple[int, ...], rule: int | Rule, name: str) -> fem.Function:
    """Field of values at the integration points of all cells.

    Args:
        domain: mesh of the field.
        shape: shape of a value; () for numbers.
        rule: rule with the points, or the degree of the standard rule.
        name: name of the field.

    Returns:
        The field, of value 0.
    """
    how = (
        {"points": rule.points, "weights": rule.weights}
        if isinstance(rule, Rule)
        else {"degree": rule}
    )
    element = basix.ufl.quadrature_element(domain.basix_cell(), value_shape=shape, **how)
    return fem.Function(fem.functionspace(domain, element), name=name)


class AtPoints:
    """An expression that can be evaluated into a field at the integration points.

    Args:
        expression: UFL expression of the field's shape.
        domain: mesh of the expression.
        rule: a rule, or the degree of the standard rule.
        cells: local cells where it is evaluated; default: all.
    """

    def __init__(
        self,
        expression: Expr,
        domain: mesh.Mesh,
        rule: int | Rule,
        cells: np.ndarray | None = None,
    ) -> None:
        self._points = (
            rule.points
            if isinstance(rule, Rule)
            else basix.make_quadrature(domain.basix_cell(), rule)[0]
        )
        self._asked = expression
        self._mesh = domain
        self._count = domain.topology.index_map(3).size_local
        self._part = cells is not None
        self._cells = np.arange(self._count, dtype=np.int32) if cells is None else cells

    @cached_property
    def compiled(self) -> fem.Expression:
        """The expression, which is compiled when it is first asked for."""
        same = map_expr_dag(_Renumbered(), self._asked)
        return fem.Expression(same, self._points, jit_options=jit.options())

    def values(self) -> np.ndarray:
        """Values on its cells, (cells, points × entries)."""
        values = np.asarray(self.compiled.eval(self._mesh, self._cells))
        return values.reshape(len(values), int(np.prod(values.shape[1:])))

    def into(self, target: fem.Function) -> None:
        """Evaluate into ``target``."""
        # a quadrature element numbers its dofs cell by cell, in the order of the evaluation
        values = self.values()
        if self._part:
            size = target.x.array.size // max(self._count, 1)
            target.x.array.reshape(self._count, size)[self._cells] = values
        else:
            target.x.array[: values.size] = values.ravel()


class _Renumbered(MultiFunction):
    """Numbers the labels of variables from 0 on in each expression.

    UFL counts them through the process, and FFCx makes the number part of the compiled code's name
    (of an expression's, not of a form's): each model of a process would be recompiled.
    """

    def __init__(self) -> None:
        super().__init__()
        self._labels: dict[Label, Label] = {}

    def label(self, old: Label) -> Label:
        return self._labels.setdefault(old, Label(len(self._labels)))

    expr = MultiFunction.reuse_if_untouched
