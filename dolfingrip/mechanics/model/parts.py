"""Parts of a strain energy: cells of one material, and membranes on the faces of cells."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import ufl
from dolfinx import fem
from ufl.core.expr import Expr

from dolfingrip.forms import chain_rule, membrane
from dolfingrip.forms.kinematics import green_lagrange
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.points import Rule
from dolfingrip.mechanics.model.sheet import Sheet, covector, facet_rule

StrainEnergy = Callable[[Expr], Expr]
"""Green–Lagrange strain (3, 3) to energy per reference volume (mJ/mm³)."""

ByPart = Mapping[tuple[str, ...], Sequence[StrainEnergy]]
"""Strain energies by names of a domain's parts, which make up the whole."""


def _as_it_is(tensor: Expr) -> Expr:
    return tensor


class Part(NamedTuple):
    """Cells of one material, or cells with a face on a membrane.

    Attributes:
        density: energy per reference volume (mJ/mm³); of a membrane per area.
        stress: its derivative by the strain (MPa; N/mm).
        dx: measure of the cells' volume.
        cells: local ones; None for all.
        area: reference area by volume of the measure, 1 for a solid.
        rule: of a membrane's integration, None for the solid's own.
        surface: what of a strain's variation the energy feels.
    """

    density: Expr
    stress: Expr
    dx: ufl.Measure
    cells: np.ndarray | None
    area: Expr = ufl.as_ufl(1)
    rule: Rule | None = None
    surface: Callable[[Expr], Expr] = _as_it_is


def solid_parts(
    u: fem.Function,
    strain_energies: Sequence[StrainEnergy] | ByPart,
    domain: Domain | None,
    degree: int,
) -> list[Part]:
    """The whole as one part, or the domain's named ones."""
    strain = ufl.variable(green_lagrange(u))

    def part(energies: Sequence[StrainEnergy], dx: ufl.Measure, cells: np.ndarray | None) -> Part:
        density = sum((energy(strain) for energy in energies), start=0 * strain[0, 0])
        return Part(density, chain_rule.by_variable(density, strain), dx, cells)

    if not isinstance(strain_energies, Mapping):
        mesh = u.function_space.mesh
        if domain is None:
            dx = ufl.Measure("dx", mesh, metadata={"quadrature_degree": degree})
        else:
            dx = domain.volume(quadrature_degree=degree)
        return [part(strain_energies, dx, None)]
    assert domain is not None
    return [
        part(energies, domain.volume(*names, quadrature_degree=degree), domain.cells(*names))
        for names, energies in strain_energies.items()
    ]


def sheet_parts(
    u: fem.Function, sheets: Sequence[Sheet], domain: Domain, degree: int
) -> list[Part]:
    """Membranes, a part for each local facet that their cells have on them."""
    found = []
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
            found.append(Part(density, stress, dx, cells, size, rule, surface))
    return found
