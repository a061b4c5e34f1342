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

TOUCH = 1 + 1e-9
"""Ratio of gap and width up to which the plate has stiffness, so that a skin that just touches it
is in contact, although round-off puts it outside."""


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
    """Signed distance (mm) of the deformed skin from the plane n · x = offset (mm)."""
    return ufl.inner(normal, ufl.SpatialCoordinate(domain) + u) - offset


def energy(gap: Expr, width: Expr, stiffness: Expr) -> Expr:
    """Barrier potential per reference area (mJ/mm²), zero from ``width`` on.

    ψ = ½ κ ĝ (1 − s)²,          s = g/ĝ from ½ to 1
    ψ = −¼ κ ĝ (ln 2s − ½),      s < ½

    This is the two-stage barrier of Chen et al. 2025. It is quadratic at first, so that Newton's
    method finds a touch in a step. It is unbounded at s = 0. Where the two meet it is twice
    continuously differentiable. (The barrier of Li et al., Incremental Potential Contact, ACM
    Trans. Graph. 39, 2020, is smooth at s = 1, too, but has no stiffness there: a finger that lies
    on its plate would pass it in the first step.)

    Args:
        gap: distance g from the plane (mm), positive.
        width: distance ĝ at which contact is first felt (mm).
        stiffness: κ (MPa); the contact pressure is κ (1 − s), so κ/2 at s = ½.

    Example:
        The pressure −dψ/dg at three quarters of the width is κ/4.

        >>> from dolfingrip.forms.evaluate import number
        >>> gap = ufl.variable(ufl.as_ufl(0.075))
        >>> round(number(-ufl.diff(energy(gap, ufl.as_ufl(0.1), ufl.as_ufl(2.0)), gap)), 9)
        0.5
    """
    s = gap / width
    first = (1 - s) ** 2 / 2
    second = -(ufl.ln(2 * s) - 0.5) / 4
    inside = ufl.conditional(ufl.lt(s, 0.5), second, first)
    return ufl.conditional(ufl.lt(s, TOUCH), stiffness * width * inside, 0 * s)
