"""Numbers from UFL expressions without a mesh, a compiler or a solver.

The examples in this folder use it. They run as tests (``tests/forms/test_examples.py``), or one
file at a time: ``scripts/run python -m doctest -v forms/neo_hookean.py``.
"""

from collections.abc import Callable, Mapping, Sequence

import basix.ufl
import ufl
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.core.expr import Expr

SOLID = ufl.Mesh(basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,)))
"""Domain of expressions in coordinates, which UFL requires; it has no cells."""


def number(
    expression: Expr | float,
    at: Sequence[float] = (),
    known: Mapping[Expr, object] | None = None,
) -> float:
    """Value of a scalar expression; derivatives in it are carried out first.

    Args:
        expression: scalar, of constants, the coordinates and what ``known`` has.
        at: coordinates (mm), where the expression contains them.
        known: values of other symbols, such as the facet normal.

    Example:
        >>> x = ufl.variable(ufl.as_ufl(3.0))
        >>> number(ufl.diff(x**2, x))
        6.0
    """
    plain = apply_derivatives(apply_algebra_lowering(ufl.as_ufl(expression)))
    return float(plain(at, dict(known or {})))


def displacement(gradient: Sequence[Sequence[float]]) -> Expr:
    """Displacement u = (F − I) X (mm), (3,), of a body deformed evenly by F.

    Args:
        gradient: deformation gradient F, (3, 3).
    """
    return (ufl.as_matrix(gradient) - ufl.Identity(3)) * ufl.SpatialCoordinate(SOLID)


def nominal_stress(density: Callable[[Expr], Expr], stretch: float, *, held: bool = False) -> float:
    """Nominal stress (MPa) of a cube that is stretched along z: P = dψ/dλ.

    The sides shrink by λ^(−1/2), which keeps the volume as an incompressible bar does, or they
    are held, so that only z changes.

    Args:
        density: ψ of the Green–Lagrange strain, (3, 3) (mJ/mm³).
        stretch: λ along z.
        held: hold the sides.
    """
    along = ufl.variable(ufl.as_ufl(float(stretch)))
    across = ufl.as_ufl(1.0) if held else 1 / ufl.sqrt(along)
    strains = [(each**2 - 1) / 2 for each in (across, across, along)]
    strain = ufl.as_matrix([[strains[i] if i == j else 0 for j in range(3)] for i in range(3)])
    return number(ufl.diff(density(strain), along))
