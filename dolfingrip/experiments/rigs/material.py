"""The printed material of a model: its element, its pressure field and its weight."""

from __future__ import annotations

import dolfinx
import numpy as np
from dolfinx import fem

from dolfingrip.config import Config, ConfigError
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import CELL

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


def weight(config: Config) -> np.ndarray:
    """Dead weight per reference volume (N/mm³), (3,)."""
    direction = np.asarray(config.gravity.direction, dtype=float)
    size = config.material.density_kg_m3 * config.gravity.acceleration_m_s2 * KG_M3_M_S2
    return size * direction / np.linalg.norm(direction)
