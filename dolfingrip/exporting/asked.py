"""What every file for another program begins with: refusals, and a whole finger of tetrahedra."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from dolfingrip.channels import PRESSURE, supply_of
from dolfingrip.config import Config
from dolfingrip.experiments.protocol import by_pressure, pressure_stops
from dolfingrip.experiments.rigs import undeformed
from dolfingrip.extensions.effect import Adapting, Displaying
from dolfingrip.meshes.cells import TETRAHEDRON
from dolfingrip.meshes.groups import SYMMETRY
from dolfingrip.meshes.solid import SolidMesh, mirrored
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.material import Material

KG_MM3: Final = 1e-9
"""kg/mm³ per kg/m³."""


def plain(config: Config, suffix: str, *, one_material: bool = True) -> Config:
    """The adapted configuration of a finger that other programs can have.

    Args:
        config: of the finger.
        suffix: of the file, for the refusal.
        one_material: whether the program gets one material for all regions.

    Raises:
        ConfigError: one line, where an effect, a film, air or a release would be lost.
    """
    for effect in config.extensions.active():
        if not isinstance(effect, Adapting | Displaying):
            raise ConfigError(f"{suffix}: no effect extensions.{effect.name()}; allowed: without")
    for name in config.film.all:
        raise ConfigError(f"{suffix}: no film.{name}; allowed: a finger without films")
    for name, cavity in config.cavity.all.items():
        if cavity.closed:
            raise ConfigError(f"{suffix}: no air in cavity.{name}; allowed: closed = false")
    if config.supply is not None:
        raise ConfigError(f"{suffix}: no supply of air; allowed: without [supply]")
    config.release.refuse(suffix)
    config.base.refuse(suffix)
    if one_material and config.material.own:
        name = config.material.own[0]
        raise ConfigError(f"{suffix}: no material.{name}; allowed: one material")
    return config.adapted()


def beside(config: Config, file: Path, suffix: str) -> Path:
    """The file of the same name with another suffix, or itself, that a program gets.

    Args:
        config: of the finger.
        file: that was asked for.
        suffix: of the file that is written.

    Raises:
        ConfigError: one line, where the finger's own mesh would be lost.
    """
    target = file.with_suffix(suffix)
    if config.mesh.file is not None and target.resolve() == Path(config.mesh.file).resolve():
        raise ConfigError(
            f"FILE {file}: {target.name} beside it is mesh.file, which would be lost; allowed: "
            "another name or folder"
        )
    return target


def supplies_kPa(config: Config, suffix: str) -> tuple[list[float], dict[str, list[float]]]:
    """Times (s) of the experiment's stops, and the pressures (kPa) of each supply there, by column.

    Args:
        config: of the finger.
        suffix: of the file, for the refusal.

    Raises:
        ConfigError: one line, where the experiment prescribes no pressures.
    """
    if not by_pressure(config):
        words = f'{suffix}: allowed: "pressure"'
        raise ConfigError(f'experiment.control = "{config.experiment.control}": {words}')
    stops = pressure_stops(config)
    supplies = (supply_of(name).name for name in config.cavity.own)
    pressures = {name: [stop.others[name] for stop in stops] for name in supplies}
    return [s.time_s for s in stops], {PRESSURE.name: [s.value for s in stops], **pressures}


def supplied(config: Config, cavity: str) -> tuple[str, float]:
    """Column of the supply of a cavity, and the part of its pressure that the cavity has.

    Args:
        config: of the finger.
        cavity: its group.
    """
    if cavity in config.cavity.own:
        return supply_of(cavity).name, 1.0
    return PRESSURE.name, config.cavity.ratio(cavity)


def no_law(material: Material, suffix: str, allowed: str) -> ConfigError:
    """The refusal of a law of the material that the other program has not.

    Args:
        material: that has it.
        suffix: of the file.
        allowed: laws that it has.
    """
    return ConfigError(f'{suffix}: no law "{material.law}"; allowed: {allowed}')


def tetrahedra(config: Config, suffix: str) -> SolidMesh:
    """The whole finger in linear tetrahedra.

    Args:
        config: adapted.
        suffix: of the file, for the refusal.

    Raises:
        ConfigError: one line, if it cannot be meshed so.
    """
    if config.mesh.file is None:
        config = config.changed(solver={"element": "P1"})
    mesh = undeformed.elements(config, 1)
    if mesh.shape is not TETRAHEDRON:
        raise ConfigError(f"mesh.file = {config.mesh.file}: {suffix}: allowed: of tetrahedra")
    return mirrored(mesh) if SYMMETRY in mesh.facets else mesh
