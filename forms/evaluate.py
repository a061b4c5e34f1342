"""Numbers from UFL expressions without a mesh, a compiler or a solver.

The examples in this folder use it. They run as tests (``tests/forms/test_examples.py``), or one
file at a time: ``scripts/run python -m doctest -v forms/neo_hookean.py``.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import ufl
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.core.expr import Expr

from dolfingrip.forms import chain_rule
from dolfingrip.forms.evaluate_many import SOLID, Array, Evaluation, constant


def number(
    expression: Expr | float,
    at: Sequence[float] = (),
    symbols: Mapping[Expr, Array | float] | None = None,
) -> float:
    """Value of a scalar expression, after its derivatives have been carried out.

    Args:
        expression: a scalar of constants, the coordinates and ``symbols``.
        at: coordinates (mm), if the expression contains them.
        symbols: values of symbols, such as the facet normal.

    Example:
        >>> x = ufl.variable(ufl.as_ufl(3.0))
        >>> number(ufl.diff(x**2, x))
        6.0
    """
    plain = apply_derivatives(apply_algebra_lowering(ufl.as_ufl(expression)))
    values = {ufl.SpatialCoordinate(SOLID): np.asarray(at), **(symbols or {})}
    (scalar,) = Evaluation([plain])({key: constant(value) for key, value in values.items()})
    return float(scalar[0, 0])


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
    strains = [(ratio**2 - 1) / 2 for ratio in (across, across, along)]
    strain = ufl.as_matrix([[strains[i] if i == j else 0 for j in range(3)] for i in range(3)])
    return number(chain_rule.by_variable(density(strain), along))
