"""Rigid plane that the skin cannot pass: the force sensor's plate."""

import ufl
from ufl.core.expr import Expr

CORNERS = {
    "triangle": ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),
    "quadrilateral": ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)),
}
"""Corners of the reference facets."""

MIDPOINTS = {
    "triangle": ((0.5, 0.5), (0.0, 0.5), (0.5, 0.0)),
    "quadrilateral": ((0.5, 0.0), (0.0, 0.5), (1.0, 0.5), (0.5, 1.0)),
}
"""Midpoints of their edges."""


def nodal_rule(facet: str, degree: int) -> dict[str, object]:
    """Measure metadata that integrates at the facet's displacement nodes.

    A barrier must see the nodes, sharp edges included: at interior points of the facets alone
    an edge could pass the plane unseen. The weights are positive and exact for linear
    functions; a midpoint has three times a corner's.

    Args:
        facet: ``triangle`` or ``quadrilateral``.
        degree: order of the displacement, 1 or 2.
    """
    points, shares = CORNERS[facet], (1.0,) * len(CORNERS[facet])
    if degree == 2:
        points += MIDPOINTS[facet]
        shares += (3.0,) * len(MIDPOINTS[facet])
    area = 0.5 if facet == "triangle" else 1.0
    return {
        "quadrature_rule": "custom",
        "quadrature_points": points,
        "quadrature_weights": tuple(area * share / sum(shares) for share in shares),
        "quadrature_degree": degree,
    }


def distance(u: Expr, domain: ufl.Mesh, normal: Expr, offset: Expr) -> Expr:
    """Signed distance (mm) of the deformed skin from the plane n · x = offset."""
    return ufl.inner(normal, ufl.SpatialCoordinate(domain) + u) - offset


def energy(gap: Expr, width: Expr, stiffness: Expr) -> Expr:
    """Barrier potential per reference area (mJ/mm²), zero from ``width`` on.

    ψ = −κ ĝ (1 − s)² ln s,  s = g/ĝ < 1

    which is twice continuously differentiable at s = 1 and unbounded at s = 0 (Li et al.,
    Incremental Potential Contact, ACM Trans. Graph. 39, 2020, eq. 6).

    Args:
        gap: distance g from the plane (mm), positive.
        width: distance ĝ at which contact is first felt (mm).
        stiffness: κ (MPa); the contact pressure is 1.2 κ at s = ½.
    """
    s = gap / width
    inside = -stiffness * width * (1 - s) ** 2 * ufl.ln(s)
    return ufl.conditional(ufl.lt(s, 1), inside, 0 * s)
