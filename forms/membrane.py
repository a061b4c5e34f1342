"""Membranes: energies of a surface's own strain, isotropic or along fibres."""

import ufl
from ufl.core.expr import Expr

ROUND = 1e-8
"""Strain below which principal strains count as equal."""


def tangential(tensor: Expr, normal: Expr) -> Expr:
    """Part of a tensor in a surface.

    For the Green–Lagrange strain this is the surface's own strain, which (F P)ᵀ(F P) gives.

    Args:
        tensor: T, (3, 3).
        normal: unit normal N, (3,).

    Returns:
        P T P with P = I − N ⊗ N, (3, 3).
    """
    p = ufl.Identity(3) - ufl.outer(normal, normal)
    return p * tensor * p


def isotropic(strain: Expr, stiffness: Expr, nu: Expr, compression: Expr = 1.0) -> Expr:
    """Energy per reference area (mJ/mm²) of a St. Venant–Kirchhoff membrane in plane stress.

    W = c W₁ + (1 − c) W₀,   W₁ = ½ Yt/(1 − ν²) ((1 − ν) E : E + ν (tr E)²)

    W₁ bears compression. W₀ is its relaxation, the tension field of a membrane that wrinkles
    (Pipkin, IMA J. Appl. Math. 36, 1986): W₁ where both principal stresses are tensile,
    ½ Yt e₁² where the lesser is not, e₁ the greater principal strain, and 0 where e₁ < 0, too.
    A membrane has no stiffness against bending, so what compression it bears in W₁ is unstable
    unless a solid supports it.

    Args:
        strain: the surface's Green–Lagrange strain E, (3, 3).
        stiffness: Young's modulus times thickness Yt (N/mm).
        nu: Poisson's ratio ν in the plane.
        compression: c, from 0 (wrinkles) to 1.

    Example:
        Pulled along z and free to narrow it has W = ½ Yt E². Narrowed further it wrinkles.

        >>> from dolfingrip.forms.evaluate import number
        >>> strain = lambda across: ufl.as_matrix([[0, 0, 0], [0, across, 0], [0, 0, 0.1]])
        >>> [round(number(isotropic(strain(-0.03), 2.0, 0.3, c)), 9) for c in (1.0, 0.0)]
        [0.01, 0.01]
        >>> [round(number(isotropic(strain(-0.1), 2.0, 0.3, c)), 6) for c in (1.0, 0.0)]
        [0.015385, 0.01]
    """
    square, trace = ufl.inner(strain, strain), ufl.tr(strain)
    bearing = stiffness / (2 * (1 - nu**2)) * ((1 - nu) * square + nu * trace**2)
    # e₁ − e₂, without its kink where both are equal
    apart = ufl.sqrt(abs(2 * square - trace**2) + ROUND**2) - ROUND
    greater, lesser = (trace + apart) / 2, (trace - apart) / 2
    wrinkled = ufl.conditional(ufl.gt(greater, 0), stiffness / 2 * greater**2, 0.0)
    field = ufl.conditional(ufl.ge(lesser + nu * greater, 0), bearing, wrinkled)
    return compression * bearing + (1 - compression) * field


def fibres(strain: Expr, stiffness: Expr, direction: Expr, compression: Expr) -> Expr:
    """Energy per reference area (mJ/mm²) of a family of straight fibres.

    W = ½ c k (f · E f)², with c = 1 in tension.

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        stiffness: k of the family, its modulus times its thickness (N/mm).
        direction: unit vector f.
        compression: c in compression.

    Example:
        >>> from dolfingrip.forms.evaluate import number
        >>> z = ufl.as_vector([0, 0, 1])
        >>> strain = lambda e: ufl.as_matrix([[0, 0, 0], [0, 0, 0], [0, 0, e]])
        >>> [round(number(fibres(strain(e), 2.0, z, 0.25)), 9) for e in (0.1, -0.1)]
        [0.01, 0.0025]
    """
    along = ufl.inner(direction, strain * direction)
    share = ufl.conditional(ufl.lt(along, 0), compression, 1.0)
    return share * stiffness / 2 * along**2


def direction(angle: Expr, normal: Expr, axis: Expr) -> Expr:
    """Direction at an angle within a surface, the same all around a surface of revolution.

    f = cos α t + sin α N × t, where t is the axis' part in the tangent plane, of length 1. So α is
    counted from the axis, anticlockwise seen from where the normal points to. Where the normal lies
    along the axis there is no t.

    Args:
        angle: α (rad).
        normal: unit normal N of the surface, (3,).
        axis: axis that the angle is counted from, (3,), of any length.

    Returns:
        Unit vector, (3,).

    Example:
        >>> from dolfingrip.forms.evaluate import number
        >>> z = ufl.as_vector([0, 0, 1])
        >>> back, side = ufl.as_vector([-1, 0, 0]), ufl.as_vector([0, 1, 0])
        >>> [round(number(direction(ufl.pi / 6, back, z)[i]), 6) for i in range(3)]
        [0.0, 0.5, 0.866025]
        >>> [round(number(direction(ufl.pi / 2, side, z)[i]), 6) for i in range(3)]
        [1.0, 0.0, 0.0]
    """
    flat = axis - ufl.inner(axis, normal) * normal
    along = flat / ufl.sqrt(ufl.inner(flat, flat))
    return ufl.cos(angle) * along + ufl.sin(angle) * ufl.cross(normal, along)
