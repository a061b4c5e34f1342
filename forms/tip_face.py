"""The direction of the finger's tip face, from which a camera's angle follows."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms.kinematics import current_area_vector


def area_vector(u: Expr, domain: ufl.Mesh) -> Expr:
    """Integrand of the deformed face's area vector, (3,), per reference area: cof(F) N.

    The integral depends on the face's rim alone (Stokes' theorem), so a local dent does not turn
    it.

    Args:
        u: displacement (mm).
        domain: mesh of the normal N.

    Example:
        A face across z that grows by a tenth both ways has 1.21 times its area.

        >>> from dolfingrip.forms.evaluate import SOLID, displacement, number
        >>> u, face = displacement([[1.1, 0, 0], [0, 1.1, 0], [0, 0, 1]]), ufl.FacetNormal(SOLID)
        >>> round(number(area_vector(u, SOLID)[2], symbols={face: (0, 0, 1)}), 9)
        1.21
    """
    return current_area_vector(u, ufl.FacetNormal(domain))
