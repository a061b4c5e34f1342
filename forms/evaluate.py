"""Numbers from UFL expressions without a mesh, a compiler or a solver.

The examples in this folder use it. They run as tests (``tests/forms/test_examples.py``), or one
file at a time: ``scripts/run python -m doctest -v forms/neo_hookean.py``.
"""

from collections.abc import Callable, Mapping, Sequence

import basix.ufl
import ufl
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.classes import Condition, Label, MultiIndex, Variable
from ufl.core.expr import Expr

from dolfingrip.forms import chain_rule

SOLID = ufl.Mesh(basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,)))
"""Domain of expressions in coordinates, which UFL requires; it has no cells."""


def number(
    expression: Expr | float,
    at: Sequence[float] = (),
    known: Mapping[Expr, object] | None = None,
) -> float:
    """Value of a scalar expression, after its derivatives have been carried out.

    Args:
        expression: a scalar of constants, the coordinates and the symbols in ``known``.
        at: coordinates (mm), if the expression contains them.
        known: values of other symbols, such as the facet normal.

    Example:
        >>> x = ufl.variable(ufl.as_ufl(3.0))
        >>> number(ufl.diff(x**2, x))
        6.0
    """
    plain = apply_derivatives(apply_algebra_lowering(ufl.as_ufl(expression)))
    return float(_folded(plain, at, dict(known or {})))


def _folded(top: Expr, at: Sequence[float], known: dict[Expr, object]) -> Expr:
    """``top`` as a number; each scalar in it is evaluated once, however often it occurs."""
    done: dict[int, Expr] = {}
    left = [top]
    while left:
        node = left[-1]
        waiting = [part for part in node.ufl_operands if id(part) not in done]
        if waiting:
            left += waiting
            continue
        left.pop()
        if id(node) in done:
            continue
        parts = [done[id(part)] for part in node.ufl_operands]
        same = all(a is b for a, b in zip(parts, node.ufl_operands, strict=True))
        found = node if same else node._ufl_expr_reconstruct_(*parts)
        if isinstance(node, Variable):
            found = parts[0]
        elif not isinstance(node, Label | MultiIndex | Condition) and _is_number(node):
            found = ufl.as_ufl(float(found(at, known)))
        done[id(node)] = found
    return done[id(top)]


def _is_number(node: Expr) -> bool:
    return not (node.ufl_shape or node.ufl_free_indices)


def displacement(gradient: Sequence[Sequence[float]]) -> Expr:
    """Displacement u = (F − I) X (mm), (3,), of a body deformed evenly by F.

    Args:
        gradient: deformation gradient F, (3, 3).
    """
    return (ufl.as_matrix(gradient) - ufl.Identity(3)) * ufl.SpatialCoordinate(SOLID)


def nominal_stress(density: Callable[[Expr], Expr], stretch: float, *, held: bool = False) -> float:
    """Nominal stress (MPa) of a cube that is stretched along z: P = dψ/dλ.

    The sides shrink by λ^(−1/2), so that the volume stays constant as in an incompressible bar. Or
    they are held, so that only the length along z changes.

    Args:
        density: ψ of the Green–Lagrange strain, (3, 3) (mJ/mm³).
        stretch: λ along z.
        held: whether the sides are held.
    """
    along = ufl.variable(ufl.as_ufl(float(stretch)))
    across = ufl.as_ufl(1.0) if held else 1 / ufl.sqrt(along)
    strains = [(each**2 - 1) / 2 for each in (across, across, along)]
    strain = ufl.as_matrix([[strains[i] if i == j else 0 for j in range(3)] for i in range(3)])
    return number(chain_rule.by_variable(density(strain), along))
