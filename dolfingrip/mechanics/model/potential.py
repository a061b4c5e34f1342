"""All energies in UFL as one term of Π, with their derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import reduce
from itertools import combinations_with_replacement
from operator import add

import numpy as np
import ufl
from dolfinx import fem
from ufl.algorithms import expand_derivatives

from dolfingrip.forms import chain_rule
from dolfingrip.forms.kinematics import (
    deformation_gradient,
    geometric_variation,
    strain_variation,
)
from dolfingrip.mechanics.model.assembly import integral, owned_vector, to_assemble
from dolfingrip.mechanics.model.carried_stress import CarriedStress
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import Sheet, integration_degree, sheet_degree
from dolfingrip.mechanics.model.parts import (
    ByPart,
    ReducedIntegration,
    StrainEnergy,
    sheet_parts,
    solid_parts,
)
from dolfingrip.mechanics.model.points import AtPoints
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.term import Coupling, Term, global_coupling
from dolfingrip.mechanics.model.unknowns import GlobalUnknown, Gradient


class Potential(Term):
    """Π(u) = ∫ Σψ(E(u)) dX + further terms, with residual and tangent in UFL.

    The tangent's geometric part takes its stress from :class:`CarriedStress` where
    ``carried`` is set (mixed integration point Newton; Magisano, Leonetti & Garcea, Int. J.
    Numer. Methods Eng. 109, 2017), else from the displacement.

    Args:
        u: displacement (mm), vector-valued, see :mod:`dolfingrip.mechanics.model.element`.
        strain_energies: densities that depend on u through E alone; by names of the domain's
            parts where they differ.
        terms: other potentials (mJ), as UFL forms in ``u``.
        carried: whether the tangent uses the carried stress.
        p: pressure field of a mixed model (MPa), which the densities contain.
        global_unknowns: global unknowns whose constants ``terms`` contain.
        domain: domain with the parts of ``strain_energies`` and the sheets of ``sheets``.
        sheets: membranes; their stress is carried like that of the solid.
        degree: degree of the quadrature of strain energies; default: the element's.

    Attributes:
        global_unknowns, sheets: the arguments.
        by_part: the argument ``strain_energies``, by names of parts; () is the whole.
        solids: strain energies of the solid with their stresses and where they are integrated.
        degree: degree of the quadrature of those without a rule of their own.
        gradient: ∂Π/∂u as a UFL form, linear in its test function.
    """

    def __init__(
        self,
        u: fem.Function,
        strain_energies: Sequence[StrainEnergy | ReducedIntegration] | ByPart,
        terms: Sequence[ufl.Form] = (),
        *,
        carried: bool = True,
        p: fem.Function | None = None,
        global_unknowns: Sequence[GlobalUnknown] = (),
        domain: Domain | None = None,
        sheets: Sequence[Sheet] = (),
        degree: int | None = None,
    ) -> None:
        space = u.function_space
        degree = degree or integration_degree(space)
        v, w = ufl.TestFunction(space), ufl.TrialFunction(space)

        all_solids = solid_parts(u, strain_energies, domain, degree)
        solids = [part for part in all_solids if part.rule is None]
        apart = [part for part in all_solids if part.rule is not None]
        if sheets:
            assert domain is not None
            apart += sheet_parts(u, sheets, domain, sheet_degree(space))
        parts = [*solids, *apart]
        self.degree, self.solids = degree, all_solids
        fields = [u] if p is None else [u, p]
        if not isinstance(strain_energies, Mapping):
            strain_energies = {(): strain_energies}
        self.by_part: ByPart = strain_energies
        self.global_unknowns = tuple(global_unknowns)
        self.sheets = tuple(sheets)
        self.singular_at_rest = bool(sheets)  # flat ones resist deflection only once deflected
        self.carried = CarriedStress(
            fields, [(part.stress, part.cells, part.rule) for part in parts if carried], degree
        )
        stresses = self.carried.of_parts or [part.stress for part in parts]

        form = sum(terms[1:], start=terms[0]) if terms else None
        value = _sum(part.area * part.density * part.dx for part in parts)
        residual = _sum(
            part.area * ufl.inner(part.stress, part.surface(strain_variation(u, v))) * part.dx
            for part in parts
        )
        tangent = _sum(
            part.area
            * (
                ufl.inner(chain_rule.along(part.stress, u, w), part.surface(strain_variation(u, v)))
                + ufl.inner(stress, part.surface(geometric_variation(v, w)))
            )
            * part.dx
            for part, stress in zip(parts, stresses, strict=True)
        )
        if form is not None:
            value += form
            residual += ufl.derivative(form, u, v)
            tangent += ufl.derivative(ufl.derivative(form, u, v), u, w)
        self.gradient = residual
        self._energy, self._stiffness = value, tangent
        self._slopes = [residual]  # by the displacement, and by p
        self._coupling: tuple[ufl.Form, ...] = ()  # blocks (u, p), (p, u) and (p, p)
        if p is not None:
            q, r = (
                argument(p.function_space) for argument in (ufl.TestFunction, ufl.TrialFunction)
            )
            constraint = ufl.derivative(_sum(part.density * part.dx for part in solids), p, q)
            across = _sum(
                ufl.inner(ufl.derivative(part.stress, p, r), strain_variation(u, v)) * part.dx
                for part in solids
            )
            self._slopes.append(constraint)
            self._coupling = (
                across, ufl.derivative(constraint, u, w), ufl.derivative(constraint, p, r)
            )  # fmt: skip
        self._jacobian = AtPoints(ufl.det(deformation_gradient(u)), space.mesh, degree)
        self._globals = (
            _GlobalForms(u, form, global_unknowns) if global_unknowns and form is not None else None
        )

    # -- forms are compiled when they are first asked for: a finger's run never asks for its energy

    def compile(self) -> None:
        """Compile all forms that Newton's method needs, which are all but the energy."""
        for form in (*self._slopes, self._stiffness, *self._coupling):
            to_assemble(form)
        _ = self._jacobian.compiled
        self.carried.compile()

    @property
    def tangent(self) -> fem.Form:
        """∂²Π/∂u²."""
        return to_assemble(self._stiffness)

    # -- as a term -------------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Energy (mJ) of the meshed part at the present unknowns."""
        return integral(self._energy)

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add the derivatives (N) by the unknowns at their present values."""
        for form, part in zip(self._slopes, gradient.fields, strict=True):
            part += owned_vector(form)
        if self._globals is not None:
            self._globals.add_slopes(gradient)

    def add_shape_gradient(self, dofs: np.ndarray, gradient: ShapeGradient) -> None:
        """Add the derivatives by the reference coordinates at the present unknowns (N)."""
        gradient.add_form(self._energy)

    def tangent_forms(self) -> Sequence[Sequence[fem.Form]]:
        """The tangent, by blocks of displacement and pressure."""
        if not self._coupling:
            return [[self.tangent]]
        across, back, within = map(to_assemble, self._coupling)
        return [[self.tangent, across], [back, within]]

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """Second derivatives by global unknowns and by any unknown."""
        return () if self._globals is None else [self._globals.coupling()]

    def smallest_jacobian(self) -> float:
        """Smallest det F over this rank's integration points."""
        return float(self._jacobian.values().min(initial=np.inf))


def _sum(forms: Iterable[ufl.Form]) -> ufl.Form:
    return reduce(add, forms)


class _GlobalForms:
    """Derivatives of an energy by global unknowns that it contains as constants."""

    def __init__(
        self, u: fem.Function, energy: ufl.Form, global_unknowns: Sequence[GlobalUnknown]
    ) -> None:
        self._globals = global_unknowns
        constants = [unknown.constant for unknown in global_unknowns]
        marks = [ufl.variable(constant) for constant in constants]
        marked = ufl.replace(energy, dict(zip(constants, marks, strict=True)))
        slopes = [ufl.diff(marked, mark) for mark in marks]
        test = ufl.TestFunction(u.function_space)
        self._first = u.function_space.dofmap.index_map.local_range[0]
        self._slopes = slopes
        # Most pairs do not meet in any energy, and forms that are zero need not be compiled.
        self._curvatures = {
            (i, j): curvature
            for i, j in combinations_with_replacement(range(len(marks)), 2)
            if not (curvature := expand_derivatives(ufl.diff(slopes[i], marks[j]))).empty()
        }
        self._mixed = [ufl.derivative(slope, u, test) for slope in slopes]

    def add_slopes(self, gradient: Gradient) -> None:
        for unknown, slope in zip(self._globals, self._slopes, strict=True):
            gradient.add(unknown, integral(slope))

    def coupling(self) -> Coupling:
        """This rank's rows, and the rows of the global unknowns."""
        mixed = [owned_vector(form) for form in self._mixed]
        within = np.zeros((len(mixed), len(mixed)))
        for (i, j), form in self._curvatures.items():
            within[i, j] = within[j, i] = integral(form)
        return global_coupling(self._globals, self._first, np.array(mixed), within)
