"""Follower pressure on a closed cavity, as the potential −p V(u)."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms.kinematics import current_area_vector


def volume_density(u: Expr, domain: ufl.Mesh) -> Expr:
    """Integrand of the cavity's volume over its reference surface (mm).

    V(u) = −∫ ⅓ x · cof(F) N dA,  x = X + u,

    by the divergence theorem; N points out of the solid, so into the cavity. The symmetry
    plane y = 0 closes a half cavity without a contribution, since x · n = 0 there. The
    tangent of −p V is symmetric as the surface is closed or ends where u or its normal part
    is prescribed (Bonet & Wood, section 8.5.2).
    """
    x = ufl.SpatialCoordinate(domain) + u
    return -ufl.inner(x, current_area_vector(u, ufl.FacetNormal(domain))) / 3


def energy(u: Expr, domain: ufl.Mesh, pressure: Expr) -> Expr:
    """Potential of the pressure (MPa) per reference area of the cavity (mJ/mm²)."""
    return -pressure * volume_density(u, domain)
