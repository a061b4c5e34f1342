"""The displacement element that a configuration asks for."""

from __future__ import annotations

from dolfingrip.config import Config, ConfigError
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import CELL


def element_name(config: Config, domain: Domain) -> str:
    """Name of the displacement element; the cells decide it if the configuration does not.

    Raises:
        ConfigError: if the element does not fit the mesh's cells, or an effect has no mixed form.
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
