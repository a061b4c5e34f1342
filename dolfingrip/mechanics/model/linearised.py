"""Strain energies to second order about a solution, as fields of another mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import ufl
from dolfinx import mesh
from ufl.core.expr import Expr

from dolfingrip.forms import chain_rule
from dolfingrip.forms.kinematics import green_lagrange
from dolfingrip.mechanics.model import points
from dolfingrip.mechanics.model.element import integration_degree
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.parts import ReducedIntegration, StrainEnergy
from dolfingrip.mechanics.model.points import AtPoints

_PLACES: Final = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Components of a symmetric tensor, one each."""


class Expansion(NamedTuple):
    """Coefficients of ψ(E₀) + S : (E − E₀) + ½ (E − E₀) : C : (E − E₀), as arrays or fields.

    Attributes:
        strain: Green–Lagrange strain E₀, (3, 3).
        stress: second Piola–Kirchhoff stress S (MPa), (3, 3).
        moduli: stresses C : B (MPa) of unit strains B, (6, 3, 3).
    """

    strain: Any
    stress: Any
    moduli: Any


class Linearised:
    """The expansion of a model's strain energies at one rule's integration points.

    Args:
        model: a model; the expansion is about its present state.
        degree: of the rule.
        reduced: whether it is that of the energies which are integrated apart.
    """

    def __init__(self, model: Model, degree: int, *, reduced: bool) -> None:
        domain = model.domain
        self.degree = degree
        self._at = points.field(domain.mesh, (3, 3), degree, "strain")
        self._strain = AtPoints(green_lagrange(model.u), domain.mesh, degree)
        self._parts: list[tuple[np.ndarray, AtPoints, AtPoints]] = []
        strain = chain_rule.strain_variable(self._at)
        for names, energies in model.potential.by_part.items():
            own = [
                each.energy if isinstance(each, ReducedIntegration) else each
                for each in energies
                if isinstance(each, ReducedIntegration) == reduced
            ]
            if not own:
                continue
            density = sum((energy(strain) for energy in own), start=0 * strain[0, 0])
            stress = chain_rule.by_variable(density, strain)
            moduli = ufl.as_tensor(
                [chain_rule.along(stress, self._at, _unit(*place)) for place in _PLACES]
            )
            cells = domain.cells(*names)
            first, second = (
                AtPoints(each, domain.mesh, degree, cells) for each in (stress, moduli)
            )
            self._parts.append((cells, first, second))

    def __bool__(self) -> bool:
        """Tell whether there are energies of this kind."""
        return bool(self._parts)

    def values(self) -> Expansion:
        """Evaluate it at the model's present state; each array is (cells, points, entries)."""
        self._strain.into(self._at)
        strain = self._strain.values()
        count = len(strain), strain.shape[1] // 9
        found = [np.zeros((*count, size)) for size in (9, 54)]
        for cells, *parts in self._parts:
            for into, part in zip(found, parts, strict=True):
                into[cells] = part.values().reshape(len(cells), count[1], -1)
        return Expansion(strain.reshape(*count, 9), *found)


def of_model(model: Model, *, full: bool) -> list[Linearised]:
    """List the expansions of a model's energies, one for each rule that it integrates with.

    Args:
        model: without a pressure field.
        full: whether its energies are integrated with the full rule.

    Returns:
        That of the energies with the solid's rule, then that of energies integrated apart.
    """
    space = model.u.function_space
    found = [
        Linearised(model, integration_degree(space, full=full), reduced=False),
        Linearised(model, integration_degree(space), reduced=True),
    ]
    return [each for each in found if each]


def fields(domain: mesh.Mesh, degree: int) -> Expansion:
    """Make an expansion's fields on a mesh.

    Args:
        domain: the mesh.
        degree: of the rule with the points.
    """
    shapes = {"strain": (3, 3), "stress": (3, 3), "moduli": (6, 3, 3)}
    return Expansion(*(points.field(domain, each, degree, n) for n, each in shapes.items()))


def energies(of: Sequence[Expansion]) -> list[StrainEnergy | ReducedIntegration]:
    """Make the strain energies of expansions, of which the second is integrated apart.

    Args:
        of: fields.
    """
    first, *apart = map(_energy, of)
    return [first, *map(ReducedIntegration, apart)]


def _energy(of: Expansion) -> StrainEnergy:
    def density(strain: Expr) -> Expr:
        change = strain - of.strain
        further = [change[place] * _matrix(of.moduli, i) for i, place in enumerate(_PLACES)]
        return ufl.inner(of.stress + sum(further[1:], start=further[0]) / 2, change)

    return density


def _matrix(moduli: Expr, which: int) -> Expr:
    return ufl.as_matrix([[moduli[which, i, j] for j in range(3)] for i in range(3)])


def _unit(i: int, j: int) -> Expr:
    """A symmetric tensor with ones at (i, j) and (j, i)."""
    found = np.zeros((3, 3))
    found[i, j] = found[j, i] = 1.0
    return ufl.as_matrix(found.tolist())
