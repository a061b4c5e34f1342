"""Pressure on a closed cavity that follows its deforming surface: the potential −p V(u)."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms.kinematics import current_area_vector


def volume_density(u: Expr, domain: ufl.Mesh) -> Expr:
    """Integrand of the cavity's volume over its reference surface (mm³/mm² = mm).

    V(u) = −∫ ⅓ x · cof(F) N dA,  x = X + u,

    by the divergence theorem. N points out of the solid, so into the cavity. A half cavity needs
    no surface on the symmetry plane y = 0, since x · n = 0 there. The tangent of −p V is symmetric
    if the surface is closed, or ends where u or its normal part is prescribed (Bonet & Wood,
    section 8.5.2).

    Args:
        u: displacement (mm).
        domain: mesh of the coordinates X and the normal N.

    Example:
        The wall at x = 1 mm of a cubic cavity that swells by a tenth in all directions: the three
        far walls of 1 mm² give 3 × 1.1³/3 mm³, and the three through the origin nothing.

        >>> from dolfingrip.forms.evaluate import SOLID, displacement, number
        >>> swollen = displacement([[1.1, 0, 0], [0, 1.1, 0], [0, 0, 1.1]])
        >>> wall = {ufl.FacetNormal(SOLID): (-1, 0, 0)}
        >>> round(3 * number(volume_density(swollen, SOLID), at=(1.0, 0.5, 0.5), symbols=wall), 9)
        1.331
    """
    x = ufl.SpatialCoordinate(domain) + u
    return -ufl.inner(x, current_area_vector(u, ufl.FacetNormal(domain))) / 3


def energy(u: Expr, domain: ufl.Mesh, pressure: Expr) -> Expr:
    """Potential of the pressure in a cavity.

    Args:
        u: displacement (mm).
        domain: mesh.
        pressure: pressure in the cavity (MPa).

    Returns:
        Energy per reference area of the cavity's wall (mJ/mm²).
    """
    return -pressure * volume_density(u, domain)
