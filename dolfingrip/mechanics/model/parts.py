"""Parts of a strain energy: cells of one material, and membranes on the faces of cells."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import ufl
from dolfinx import fem
from ufl.core.expr import Expr

from dolfingrip.forms import chain_rule, membrane
from dolfingrip.forms.kinematics import green_lagrange
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import Sheet, covector, facet_rule, integration_degree
from dolfingrip.mechanics.model.points import Rule

StrainEnergy = Callable[[Expr], Expr]
"""A function from Green–Lagrange strain (3, 3) to energy per reference volume (mJ/mm³)."""


@dataclass(frozen=True)
class ReducedIntegration:
    """A strain energy that is integrated with the element's reduced rule where others are not.

    The energy of a change of volume, nearly incompressible, locks at the points of a full rule.

    Attributes:
        energy: energy as a function of the strain.
    """

    energy: StrainEnergy


ByPart = Mapping[tuple[str, ...], Sequence[StrainEnergy | ReducedIntegration]]
"""Strain energies by the names of a domain's parts, which together are the whole."""


def _as_it_is(tensor: Expr) -> Expr:
    return tensor


class PartEnergy(NamedTuple):
    """Cells of one material, or cells with a face on a membrane.

    Attributes:
        density: energy per reference volume (mJ/mm³); for a membrane, per area.
        stress: its derivative by the strain (MPa; N/mm).
        dx: measure of the cells' volume.
        cells: local cells; None for all.
        area: ratio of reference area and volume of the measure; 1 for a solid.
        rule: integration rule, or its degree; None for the solid's own rule.
        surface: projects a strain's variation to the part that changes the energy.
    """

    density: Expr
    stress: Expr
    dx: ufl.Measure
    cells: np.ndarray | None
    area: Expr = ufl.as_ufl(1)
    rule: Rule | int | None = None
    surface: Callable[[Expr], Expr] = _as_it_is


def solid_parts(
    u: fem.Function,
    strain_energies: Sequence[StrainEnergy | ReducedIntegration] | ByPart,
    domain: Domain | None,
    degree: int,
) -> list[PartEnergy]:
    """The whole as one part, or the domain's named parts; reduced integration makes parts, too."""
    strain = chain_rule.strain_variable(green_lagrange(u))
    coarse = integration_degree(u.function_space)

    def volume(names: Sequence[str], degree: int) -> ufl.Measure:
        if domain is None:
            return ufl.Measure("dx", u.function_space.mesh, metadata={"quadrature_degree": degree})
        return domain.volume(*names, quadrature_degree=degree)

    def part(
        energies: Sequence[StrainEnergy], names: Sequence[str], rule: int | None
    ) -> PartEnergy:
        density = sum((energy(strain) for energy in energies), start=0 * strain[0, 0])
        cells = domain.cells(*names) if domain is not None and (names or rule) else None
        stress = chain_rule.by_variable(density, strain)
        return PartEnergy(density, stress, volume(names, rule or degree), cells, rule=rule)

    by_part = strain_energies if isinstance(strain_energies, Mapping) else {(): strain_energies}
    parts = []
    for names, energies in by_part.items():
        apart = [law.energy for law in energies if isinstance(law, ReducedIntegration)]
        finely = [law for law in energies if not isinstance(law, ReducedIntegration)]
        if finely:
            parts.append(part(finely, names, None))
        if apart:
            parts.append(part(apart, names, coarse))
    return sorted(parts, key=lambda part: part.rule is not None)


def sheet_parts(
    u: fem.Function, sheets: Sequence[Sheet], domain: Domain, degree: int
) -> list[PartEnergy]:
    """The parts of membranes, one for each local facet that their cells have on them."""
    parts = []
    for sheet in sheets:
        for facet, cells in domain.sheets[sheet.name].items():
            way = covector(domain.mesh, facet)
            size = ufl.sqrt(ufl.inner(way, way))
            normal = way / size

            def surface(tensor: Expr, normal: Expr = normal) -> Expr:
                return membrane.tangential(tensor, normal)

            strain = ufl.variable(surface(green_lagrange(u)))
            density = sheet.energy(strain, normal)
            rule = facet_rule(domain.mesh, facet, degree)
            dx = domain.behind(sheet.name, facet, **rule.metadata())
            stress = chain_rule.by_variable(density, strain)
            parts.append(PartEnergy(density, stress, dx, cells, size, rule, surface))
    return parts
