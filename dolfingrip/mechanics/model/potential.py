"""The total potential Π(u) and what is derived from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import ufl
from dolfinx import fem
from ufl.core.expr import Expr

from dolfingrip.forms.kinematics import (
    deformation_gradient,
    geometric_variation,
    green_lagrange,
    strain_variation,
)
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.carried_stress import CarriedStress
from dolfingrip.mechanics.model.element import integration_degree
from dolfingrip.mechanics.model.points import AtPoints

StrainEnergy = Callable[[Expr], Expr]
"""Green–Lagrange strain (3, 3) to energy per reference volume (mJ/mm³)."""


class Potential:
    """Π(u) = ∫ Σψ(E(u)) dX + further terms, with residual and tangent in UFL.

    The tangent's geometric part takes its stress from :class:`CarriedStress` where
    ``carried`` is set (mixed integration point Newton; Magisano, Leonetti & Garcea, Int. J.
    Numer. Methods Eng. 109, 2017), else from the displacement.

    Args:
        u: displacement (mm), vector-valued, see :mod:`dolfingrip.mechanics.model.element`.
        strain_energies: densities that depend on u through E alone.
        terms: other potentials (mJ), as UFL forms in ``u``.
        carried: use the carried stress in the tangent.
        p: pressure field of a mixed model (MPa), which the densities contain.

    Attributes:
        gradient: ∂Π/∂u as a UFL form, linear in its test function.
        value, residual, tangent: Π and its derivatives with respect to u.
        constraint: derivative of Π with respect to p; None without p.
        coupling: blocks (u, p), (p, u) and (p, p) of the tangent; empty without p.
    """

    def __init__(
        self,
        u: fem.Function,
        strain_energies: Sequence[StrainEnergy],
        terms: Sequence[ufl.Form] = (),
        *,
        carried: bool = True,
        p: fem.Function | None = None,
    ) -> None:
        space = u.function_space
        degree = integration_degree(space)
        dx = ufl.Measure("dx", space.mesh, metadata={"quadrature_degree": degree})
        v, w = ufl.TestFunction(space), ufl.TrialFunction(space)

        strain = ufl.variable(green_lagrange(u))
        density = sum((energy(strain) for energy in strain_energies), start=0 * strain[0, 0])
        stress = ufl.diff(density, strain)
        fields = [u] if p is None else [u, p]
        self.carried = CarriedStress(fields, stress, degree) if carried else None
        geometric = self.carried.stress if self.carried else stress

        rest = sum(terms[1:], start=terms[0]) if terms else None
        value = density * dx
        residual = ufl.inner(stress, strain_variation(u, v)) * dx
        tangent = (
            ufl.inner(ufl.derivative(stress, u, w), strain_variation(u, v))
            + ufl.inner(geometric, geometric_variation(v, w))
        ) * dx
        if rest is not None:
            value += rest
            residual += ufl.derivative(rest, u, v)
            tangent += ufl.derivative(ufl.derivative(rest, u, v), u, w)
        self.gradient = residual
        self.value, self.residual, self.tangent = map(_compiled, (value, residual, tangent))
        self.constraint: fem.Form | None = None
        self.coupling: tuple[fem.Form, ...] = ()
        if p is not None:
            q, r = (
                argument(p.function_space) for argument in (ufl.TestFunction, ufl.TrialFunction)
            )
            constraint = ufl.derivative(density * dx, p, q)
            across = ufl.inner(ufl.derivative(stress, p, r), strain_variation(u, v)) * dx
            blocks = (across, ufl.derivative(constraint, u, w), ufl.derivative(constraint, p, r))
            self.constraint = _compiled(constraint)
            self.coupling = tuple(map(_compiled, blocks))
        determinant = ufl.det(deformation_gradient(u))
        self._jacobian = AtPoints(determinant, space.mesh, degree)

    def smallest_jacobian(self) -> float:
        """Smallest det F over this rank's integration points."""
        return float(self._jacobian.values().min(initial=np.inf))


def _compiled(form: ufl.Form) -> fem.Form:
    return fem.form(form, jit_options=jit.options())
