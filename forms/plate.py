"""Rigid plane that the skin cannot pass: the force sensor's plate."""

import ufl
from ufl.core.expr import Expr

NODES = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.0, 0.5), (0.5, 0.0))
"""Corners and edge midpoints of the reference triangle."""

WEIGHTS = {1: (1 / 6,) * 3, 2: (1 / 24,) * 3 + (1 / 8,) * 3}
"""Positive weights at the nodes of a linear or quadratic facet, exact for linear functions."""


def nodal_rule(degree: int) -> dict[str, object]:
    """Measure metadata that integrates at the facet's displacement nodes.

    A barrier must see the nodes, sharp edges included: at interior points of the facets alone
    an edge could pass the plane unseen.
    """
    weights = WEIGHTS[degree]
    return {
        "quadrature_rule": "custom",
        "quadrature_points": NODES[: len(weights)],
        "quadrature_weights": weights,
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
