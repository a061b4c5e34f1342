"""What a camera sees of the tip face: its mean displacement and its rotation."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms.kinematics import current_area_vector


def area_vector(u: Expr, domain: ufl.Mesh) -> Expr:
    """Integrand of the deformed face's area vector, (3,), per reference area: cof(F) N.

    The integral depends on the face's rim alone (Stokes), so local indentations do not tilt it.
    """
    return current_area_vector(u, ufl.FacetNormal(domain))
