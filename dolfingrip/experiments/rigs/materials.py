"""The materials of a finger: energy by the chosen law, dead weight, and films."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from operator import add

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.config import Config, Film
from dolfingrip.experiments.rigs.undeformed import REST
from dolfingrip.extensions.site import Site
from dolfingrip.forms import bulk_modulus, membrane, mixed_bulk_modulus, saint_venant
from dolfingrip.mechanics.model.dead_weight import DeadWeight
from dolfingrip.mechanics.model.element import Sheet
from dolfingrip.mechanics.model.inertia import T_MM3
from dolfingrip.mechanics.model.parts import StrainEnergy
from dolfingrip.sections.material import Material
from dolfingrip.sections.setup import Setup

TABLE = "material"
"""Table of the configuration with the material of all regions that have none of their own."""


@dataclass(frozen=True, slots=True)
class BaseMaterial:
    """Constants of the base material's energy on a mesh.

    Attributes:
        material: material of the configuration.
        mu, lmbda: moduli at small strain (MPa).
        constants: all constants by name; readings can be derived by them.
        table: table of the configuration; these names begin with it.
    """

    material: Material
    mu: fem.Constant
    lmbda: fem.Constant
    constants: dict[str, fem.Constant]
    table: str = TABLE

    @classmethod
    def on(cls, mesh: dolfinx.mesh.Mesh, material: Material, table: str = TABLE) -> BaseMaterial:
        """The material's constants on ``mesh``."""
        made = {
            name: fem.Constant(mesh, np.asarray(value, dtype=PETSc.ScalarType))
            for name, value in values(material, table).items()
        }
        return cls(material, made[f"{table}.mu_MPa"], made[f"{table}.lmbda_MPa"], made, table)

    def energy(self, strain: Expr, p: fem.Function | None = None) -> Expr:
        """Energy per reference volume (mJ/mm³); mixed if there is a pressure field p."""
        if p is None:
            return self.of_shape(strain) + self.of_volume(strain)
        return self.of_shape(strain) + mixed_bulk_modulus.energy(strain, p, self._volumetric)

    def of_shape(self, strain: Expr) -> Expr:
        """The part of the energy without :meth:`of_volume`."""
        by_key = {key: self.constants[f"{self.table}.{key}"] for key in self.material.constants()}
        return self.material.of_shape(strain, by_key)

    def of_volume(self, strain: Expr) -> Expr:
        """The part that depends on the change of volume alone; it is stiff if ν is near 0.5."""
        return bulk_modulus.energy(strain, self._volumetric)

    @property
    def _volumetric(self) -> Expr:
        return self.material.volumetric(self.mu, self.lmbda)


def values(material: Material, table: str = TABLE) -> dict[str, np.ndarray | float]:
    """Values of the constants of a material's energy, by name.

    Args:
        material: a material of the configuration.
        table: table of the configuration that the names begin with.

    Returns:
        Each constant's value in the unit of its name; MPa for moduli, and a number or (n,)
        numbers.
    """
    constants: dict[str, np.ndarray | float] = {
        f"{table}.mu_MPa": material.shear_MPa,
        f"{table}.lmbda_MPa": material.lmbda_MPa,
    }
    for key, value in material.constants().items():
        constants[f"{table}.{key}"] = (
            np.array(value, dtype=float) if isinstance(value, tuple) else value
        )
    return constants


def weight_name(part: str = REST) -> str:
    """Name of a part's constant for its dead weight."""
    return "gravity.weight_N_mm3" if part == REST else f"material.{part}.weight_N_mm3"


def weight_value(config: Setup, part: str = REST) -> np.ndarray:
    """Dead weight of a part per reference volume (N/mm³), (3,)."""
    density = config.material.of(part).density_kg_m3
    return np.asarray(T_MM3 * density * config.gravity.falls_mm_s2)


def density_name(part: str = REST) -> str:
    """Name of a part's constant for its density."""
    return "inertia.density_t_mm3" if part == REST else f"material.{part}.density_t_mm3"


def density_value(config: Setup, part: str = REST) -> float:
    """Density of a part (t/mm³)."""
    return T_MM3 * config.material.of(part).density_kg_m3


def densities(site: Site) -> dict[tuple[str, ...], fem.Constant]:
    """Density (t/mm³) of each part that has mass, by its name; () is the whole.

    Args:
        site: of the finger; the constants are added to its parameters. Its films that are layers
            have none.
    """
    return _of_parts(site, density_name, density_value)


def _of_parts(
    site: Site, name: Callable[[str], str], value: Callable[[Setup, str], np.ndarray | float]
) -> dict[tuple[str, ...], fem.Constant]:
    """A constant for each part that has mass, which parts without a material of their own share."""
    config, parts = site.config, site.domain.parts
    for part in (REST, *(part for part in parts if part in config.material.own)):
        made = fem.Constant(site.domain.mesh, np.asarray(value(config, part), PETSc.ScalarType))
        site.parameters.setdefault(name(part), made)
    layers = {film.region for film in config.film.layers.values()}
    massive: list[tuple[str, ...]] = [(part,) for part in parts if part not in layers] or [()]
    shared = site.parameters[name(REST)]
    return {names: site.parameters.get(name("".join(names)), shared) for names in massive}


def dead_weight(site: Site) -> DeadWeight | None:
    """The weight of all parts of a model under construction; None without gravity.

    Its constants are always added to the site's parameters. A film that is a layer has no weight,
    because the reduced rule leaves modes of its elements without energy, and nothing bears a weight
    in these modes at rest.
    """
    weights = _of_parts(site, weight_name, weight_value)
    if not site.config.gravity.acceleration_m_s2:
        return None
    return DeadWeight(site.u, site.domain, weights)


BACK = ufl.as_vector([-1, 0, 0])
"""Normal of a layer, which lies in a plane x = const."""


def film_value(config: Config, name: str, key: str) -> np.ndarray:
    """Value of a film's constant."""
    film = config.film.all[name]
    value = config.film_thickness_mm(film) if key == "thickness_mm" else getattr(film, key)
    return np.asarray(value, dtype=float)


def _constants(
    config: Config, name: str, mesh: dolfinx.mesh.Mesh, constants: dict[str, fem.Constant]
) -> Callable[[str], fem.Constant]:
    """Makes each constant of a film once."""

    def constant(key: str) -> fem.Constant:
        full = f"film.{name}.{key}"
        if full not in constants:
            constants[full] = fem.Constant(mesh, film_value(config, name, key))
        return constants[full]

    return constant


def layer_energy(
    config: Config,
    name: str,
    film: Film,
    mesh: dolfinx.mesh.Mesh,
    constants: dict[str, fem.Constant],
) -> StrainEnergy:
    """Strain energy of a film of elements, whose modulus is its stiffness by its thickness."""
    constant = _constants(config, name, mesh, constants)
    thickness = constant("thickness_mm")

    def energy(strain: Expr) -> Expr:
        young = constant("Et_N_per_mm") / thickness
        solid = saint_venant.energy(strain, young, constant("nu"))
        families = _families(film, strain, BACK, constant)
        return reduce(add, [family / thickness for family in families], solid)

    return energy


def sheets(
    config: Config, mesh: dolfinx.mesh.Mesh, constants: dict[str, fem.Constant]
) -> list[Sheet]:
    """Energies of all membranes.

    Args:
        config: configuration with the membranes.
        mesh: mesh of the finger.
        constants: constants by name, which those of the membranes are added to.

    Returns:
        One sheet for each membrane, with its energy (mJ/mm²).
    """
    membranes = []
    for name, film in config.film.membranes.items():
        constant = _constants(config, name, mesh, constants)
        membranes.append(Sheet(name, _membrane_energy(film, constant)))
    return membranes


def _membrane_energy(
    film: Film, constant: Callable[[str], fem.Constant]
) -> Callable[[Expr, Expr], Expr]:
    def energy(strain: Expr, normal: Expr) -> Expr:
        parts = _families(film, strain, normal, constant)
        if film.Et_N_per_mm:
            stiffness, nu = constant("Et_N_per_mm"), constant("nu")
            share = constant("compression")
            parts.insert(0, membrane.isotropic(strain, stiffness, nu, share))
        return reduce(add, parts)

    return energy


def _families(
    film: Film, strain: Expr, normal: Expr, constant: Callable[[str], fem.Constant]
) -> list[Expr]:
    """Energy per reference area of each family of fibres."""
    families = []
    for i in range(len(film.fibre_deg)):
        angle = constant("fibre_deg")[i] * (ufl.pi / 180)
        along = membrane.direction(angle, normal, ufl.as_vector(film.fibre_axis))
        stiffness = constant("fibre_Et_N_per_mm")[i]
        families.append(membrane.fibres(strain, stiffness, along, constant("compression")))
    return families
