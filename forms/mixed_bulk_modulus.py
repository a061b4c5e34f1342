"""Resistance to a change of volume by a pressure field, for nearly incompressible solids."""

import ufl
from ufl.core.expr import Expr

from dolfingrip.forms import invariants


def energy(strain: Expr, p: Expr, bulk: Expr) -> Expr:
    """Perturbed Lagrangian per reference volume (MPa = mJ/mm³).

    L = p ln J − p²/(2K)

    It is K/2 (ln J)² where it is stationary in p, with p = K ln J: the Legendre transform of
    :mod:`dolfingrip.forms.bulk_modulus`. But p may be chosen smoother than ln J is, and it stays
    finite as K grows (Simo, Taylor & Pister, Comput. Methods Appl. Mech. Eng. 51, 1985; Bonet &
    Wood, section 8.6).

    Args:
        strain: Green–Lagrange strain E, (3, 3).
        p: pressure (MPa), positive in tension.
        bulk: bulk modulus K (MPa), or λ if the neo-Hookean energy of μ is added.

    Example:
        A cube whose sides are held has P = p/λ: 3/2 at a stretch of 2.

        >>> from dolfingrip.forms.evaluate import nominal_stress
        >>> round(nominal_stress(lambda strain: energy(strain, 3.0, 9.0), 2.0, held=True), 9)
        1.5
    """
    ln_j = ufl.ln(ufl.det(invariants.right_cauchy_green(strain))) / 2
    return p * ln_j - p**2 / (2 * bulk)
