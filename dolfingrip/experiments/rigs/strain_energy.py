"""The strain energies of a finger's parts, by the configuration's materials, films and effects."""

from __future__ import annotations

from functools import partial

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.base_material import BaseMaterial
from dolfingrip.experiments.rigs.films import layer_energy
from dolfingrip.experiments.rigs.regions import REST
from dolfingrip.extensions.site import Site
from dolfingrip.mechanics.model.parts import ByPart, ReducedIntegration, StrainEnergy


def strain_energies(
    config: Config, site: Site, base: BaseMaterial
) -> list[StrainEnergy | ReducedIntegration] | ByPart:
    """The strain energies of all parts; their constants are added to the site's parameters.

    Effects act on parts that have no material of their own.

    Args:
        config: materials, films and effects.
        site: a site whose domain has a part for each region with a material of its own.
        base: material of all parts that have no material of their own.
    """
    mesh, layers = site.domain.mesh, config.film.layers
    # the energy of a change of volume is integrated apart, with fewer points
    selective = config.integration == "selective" and site.p is None and config.hexahedra
    found: dict[tuple[str, ...], list[StrainEnergy | ReducedIntegration]] = {}
    for part in site.domain.parts or (REST,):
        film = next((name for name, each in layers.items() if each.region == part), None)
        if film is not None:
            layer = layer_energy(config, film, layers[film], mesh, site.parameters)
            found[part,] = [ReducedIntegration(layer)]
            continue
        material = base
        if part != REST:
            material = BaseMaterial.on(mesh, config.material.of(part), f"material.{part}")
            site.parameters |= material.constants
        energy: StrainEnergy = (
            material.of_shape if selective else partial(material.energy, p=site.p)
        )
        if part == REST:
            energy = config.extensions.strain_energy(energy, site)
        found[part,] = [energy, ReducedIntegration(material.of_volume)] if selective else [energy]
    return found if site.domain.parts else found[REST,]
