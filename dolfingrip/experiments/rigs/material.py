"""The printed material of a model: its element, its pressure field and its weight."""

from __future__ import annotations

from collections.abc import Mapping

import dolfinx
import numpy as np
import ufl
from dolfinx import fem

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs.regions import REST
from dolfingrip.forms import gravity
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import CELL
from dolfingrip.sections.setup import Setup

KG_M3_M_S2 = 1e-9
"""N/mm³ per kg/m³ · m/s²."""


def element_name(config: Config, domain: Domain) -> str:
    """Name of the displacement element; where the configuration names none, the cells decide.

    Raises:
        ConfigError: the element does not fit the mesh's cells, or an effect has no mixed form.
    """
    cell = domain.mesh.ufl_cell().cellname()
    if config.solver.element is None:
        return "S2" if cell == "hexahedron" else "P2"
    needed = CELL[config.solver.element]
    if cell != needed:
        allowed = " or ".join(f'"{name}"' for name, other in CELL.items() if other == cell)
        raise ConfigError(
            f'solver.element = "{config.solver.element}": the mesh has other cells, '
            f"{cell}s; allowed: {allowed}"
        )
    if config.solver.element == "P2-P1":
        _refuse_unmixed(config)
    return config.solver.element


def _refuse_unmixed(config: Config) -> None:
    for effect in config.extensions.active():
        if not effect.mixed:
            raise ConfigError(
                f'extensions.{effect.name()}: allowed: with solver.element other than "P2-P1" only'
            )


def pressure_field(element: str, mesh: dolfinx.mesh.Mesh) -> fem.Function | None:
    """Pressure (MPa) of a mixed element, None of another."""
    if element != "P2-P1":
        return None
    return fem.Function(fem.functionspace(mesh, ("Lagrange", 1)), name="pressure_MPa")


def weights_of(config: Config, domain: Domain) -> dict[str, fem.Constant]:
    """Dead weights per reference volume (N/mm³) of the domain's materials, by constant's name."""
    parts = (REST, *(part for part in domain.parts if part in config.material.own))
    return {weight_name(part): fem.Constant(domain.mesh, weight(config, part)) for part in parts}


def weight_name(part: str = REST) -> str:
    """Name of the constant that is a part's dead weight."""
    return "gravity.weight_N_mm3" if part == REST else f"material.{part}.weight_N_mm3"


def weight(config: Config, part: str = REST) -> np.ndarray:
    """Dead weight of a part per reference volume (N/mm³), (3,)."""
    direction = np.asarray(config.gravity.direction, dtype=float)
    size = config.gravity.acceleration_m_s2 * density(config, part)
    return size * direction / np.linalg.norm(direction)


def density(config: Config, part: str = REST) -> float:
    """Density of a part (N/mm³ per m/s²)."""
    return config.material.of(part).density_kg_m3 * KG_M3_M_S2


def weighed(config: Setup, domain: Domain) -> list[tuple[str, ...]]:
    """Parts of a domain that have weight, each with names for its measure and its material.

    A film that is a layer has none: the reduced rule leaves its elements modes without energy, and
    at rest nothing else bears a weight on them.

    Args:
        config: with the films.
        domain: with its parts.

    Returns:
        Names as :meth:`~dolfingrip.mechanics.model.domain.Domain.volume` takes them: of one part,
        or none where the solid is one.
    """
    if not domain.parts:
        return [()]
    layers = {film.region for film in config.film.layers.values()}
    return [(part,) for part in domain.parts if part not in layers]


def weight_energy(
    config: Setup, domain: Domain, u: fem.Function, known: Mapping[str, fem.Constant]
) -> list[ufl.Form]:
    """Energies (mJ of the meshed part) of the dead weight, part by part; none without gravity.

    Args:
        config: with the films.
        domain: with its parts.
        u: displacement (mm).
        known: constants by name, with those of :func:`weights_of`.
    """
    degree = u.function_space.ufl_element().degree
    rest = known[weight_name()]
    if not np.any(rest.value):
        return []
    return [
        gravity.energy(u, known.get(weight_name(*part), rest))
        * domain.volume(*part, quadrature_degree=degree)
        for part in weighed(config, domain)
    ]
