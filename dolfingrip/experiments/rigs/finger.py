"""The finger's model, from the configuration alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce
from operator import add

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from dolfingrip.channels import AMBIENT_KPA
from dolfingrip.config import KPA, Config, ConfigError
from dolfingrip.experiments.rigs import materials
from dolfingrip.experiments.rigs.fixture import moving_clamp, normal_of, supply, surround
from dolfingrip.experiments.rigs.food import beside
from dolfingrip.experiments.rigs.pneumatics import MM3, line_of
from dolfingrip.experiments.rigs.undeformed import REST
from dolfingrip.extensions.effect import Stage
from dolfingrip.extensions.site import Site
from dolfingrip.extensions.supply import Supply
from dolfingrip.forms import cavity_pressure, trapped_air
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import (
    CELL,
    displacement_element,
    integration_degree,
    pressure_field,
)
from dolfingrip.mechanics.model.inertia import Inertia
from dolfingrip.mechanics.model.model import Control, Model, Prescribed, SetPoint
from dolfingrip.mechanics.model.parts import ByPart, ReducedIntegration, StrainEnergy
from dolfingrip.mechanics.model.pneumatics import Air
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.state import History, Memory, State
from dolfingrip.mechanics.model.supports import at_rest
from dolfingrip.mechanics.model.term import Term
from dolfingrip.mechanics.model.unknowns import GlobalUnknown
from dolfingrip.mechanics.newton.air_supply import AirSupply, supplied
from dolfingrip.mechanics.newton.volume_control import volume_controlled
from dolfingrip.sections.supply import AirLine


@dataclass(frozen=True, slots=True)
class Additions:
    """Loads, terms and controls that an experiment adds to the model of a finger.

    Attributes:
        loads: energies in UFL (mJ of the meshed part).
        terms: further terms of the potential.
        global_unknowns: unknowns of these terms.
        controls: further controls by name with unit.
        memories: further parts of the state.
        inertia_from_s: the model's time up to which a dynamic finger moves quasi-statically.
    """

    loads: Sequence[ufl.Form] = ()
    terms: Sequence[Term] = ()
    global_unknowns: Sequence[GlobalUnknown] = ()
    controls: Mapping[str, Prescribed] = field(default_factory=dict)
    memories: Sequence[Memory] = ()
    inertia_from_s: float = 0.0


AIR_SCALE_MPA = 0.01
"""Pressure of trapped air that weighs as much as a displacement of 1 mm."""
LEAST_MM3 = 1e-6
"""Volume of openings below which they lie in the plane z = 0, where they take no part."""

Adds = Callable[[Site], Additions]
"""Returns what an experiment adds, from the fields, constants and contacts of the finger."""


def nothing(site: Site) -> Additions:
    """Add nothing."""
    return Additions()


@dataclass(slots=True)
class FingerModel:
    """A pressurised finger, free or with the plate that faces it.

    Attributes:
        config: configuration that it was built from, after extensions of geometry and set-up.
        site: fields, constants and contacts of the model.
        model: model that is solved.
        by_pressure: the model under pressure control; it is ``model`` itself, unless the control is
            the volume.
        rest: state that readings count from; it starts as the undeformed state.
        inertia: of the finger; None: it is quasi-static.
        air: the supply of its cavities' air; None: their pressure, or volume, is prescribed.
    """

    config: Config
    site: Site
    model: Model
    by_pressure: Model
    rest: State
    inertia: Inertia | None = None
    air: AirSupply | None = None

    @property
    def plate(self) -> RigidPlate | None:
        """Plate of the force sensor; None if none faces the finger."""
        return self.site.plate

    @property
    def contact(self) -> BarrierContact | None:
        """Contact of the skin with itself; None if there is none."""
        return self.site.contact

    def pressure_in(self, cavity: str) -> Control:
        """Pressure (kPa) in a cavity: a part of the supply's, or that of its trapped air."""
        settings = self.config.cavity.of(cavity)
        if settings.closed:
            return Control(self.site.unknowns[f"{cavity}.pressure_MPa"].constant, KPA)
        if supply := self.site.supplies.get(cavity):
            return Control(supply, KPA)
        ratio = settings.pressure_ratio
        return Control(self.site.pressure, KPA / ratio if ratio else np.inf)

    @property
    def pressures(self) -> dict[str, Control]:
        """Pressure (kPa) in each cavity by its name."""
        return {name: self.pressure_in(name) for name in self.site.domain.cavities}

    @property
    def parameters(self) -> dict[str, fem.Constant]:
        """Constants of the potential by name; readings can be derived by them."""
        return self.site.parameters

    @property
    def cavity(self) -> Control:
        """The cavity's pressure, which is the regulator's unless an extension is in between."""
        return Control(self.site.pressure, KPA)

    @property
    def enclosed(self) -> ufl.Form:
        """Volume of all meshed cavities (mm³), integrated exactly."""
        return self.volume_of(*self.site.domain.cavities)

    def volume_of(self, *cavities: str) -> ufl.Form:
        """Volume of some meshed cavities (mm³), integrated exactly."""
        site = self.site
        if not cavities:  # of a solid body
            return site.fixed(0.0) * ufl.div(site.u) * site.domain.volume(quadrature_degree=2)
        degree = 3 * site.u.function_space.ufl_element().degree
        exactly = site.domain.surface(*cavities, quadrature_degree=degree)
        density = cavity_pressure.volume_density(site.u, site.domain.mesh)
        closing = sum(site.domain.closing_mm3.get(name, 0.0) for name in cavities)
        if abs(closing) > LEAST_MM3:
            area_mm2 = sum(site.area_mm2(name) for name in cavities)
            density += site.fixed(closing * site.domain.copies / area_mm2)
        return density * exactly

    @property
    def driven(self) -> ufl.Form:
        """Volume that the regulator's pressure works on (mm³): each cavity's by its ratio."""
        ratio = self.config.cavity.ratio
        volumes = [(ratio(name), self.volume_of(name)) for name in self.site.domain.cavities]
        if all(part == 1 for part, _ in volumes):
            return self.enclosed
        return reduce(add, [self.site.fixed(part) * volume for part, volume in volumes])

    def control_volume(self) -> None:
        """Replace the model by one of the same state, controlled by the volume that is driven."""
        self.model = volume_controlled(self.model, self.cavity, self.driven)

    def supply_air(self, supply: AirLine) -> None:
        """Replace the model by one of the same state whose cavities' air comes from a supply."""
        air = Air(line_of(supply), syringe=supply.source == "syringe")
        self.air = AirSupply(
            self.site.u, self.cavity, self.driven, self.site.domain.copies, air,
            self.site.set_point or self.cavity, supply.error_kPa * KPA, MM3 * supply.syringe_cm3,
        )  # fmt: skip
        self.model = supplied(self.model, self.air)

    def take_over(self, config: Config, at_rest_mm: np.ndarray) -> None:
        """Put the plate and set the supply's stages as the adapted ``config`` asks for.

        Args:
            config: another configuration of the same model.
            at_rest_mm: displacement at rest (local array, mm), from which the plate's gap counts.
        """
        if self.plate is not None:
            self.plate.turn(normal_of(config.plate), config.plate.gap_mm, at_rest_mm)
        for control in self.by_pressure.controls.values():
            if isinstance(control, Supply):
                control.stages = config.extensions.active(Stage)
        if self.air is not None and config.supply is not None:
            self.air.air.line = line_of(config.supply)


def pressures(config: Config, site: Site) -> list[ufl.Form]:
    """Potentials of the pressures in all cavities (mJ).

    It is a part of the regulator's, that of the cavity's own supply, or that of its trapped air.

    Raises:
        ConfigError: one line, if the configuration names a cavity that the mesh has not.
    """
    domain, degree = site.domain, 2 * site.u.function_space.ufl_element().degree
    for name in config.cavity.all:
        if name not in domain.cavities:
            raise ConfigError(
                f"cavity.{name}: not in the mesh; allowed: {', '.join(domain.cavities)}"
            )
    energy = cavity_pressure.energy(site.u, domain.mesh, site.pressure)
    by_ratio: dict[float, list[str]] = {}
    parts = []
    for name in domain.cavities:
        if config.cavity.of(name).closed:
            parts.append(trapped(config, site, name))
        elif name in config.cavity.own:
            site.supplies[name] = site.fixed(0.0)
            supplied = cavity_pressure.energy(site.u, domain.mesh, site.supplies[name])
            parts.append(supplied * domain.surface(name, quadrature_degree=degree))
        else:
            by_ratio.setdefault(config.cavity.ratio(name), []).append(name)
    for ratio, names in by_ratio.items():
        inside = domain.surface(*names, quadrature_degree=degree)
        parts.append(energy * inside if ratio == 1 else site.fixed(ratio) * energy * inside)
    return parts


def trapped(config: Config, site: Site, name: str) -> ufl.Form:
    """Potential of the air in a closed cavity, whose pressure becomes an unknown (mJ)."""
    cavity, mesh, degree = config.cavity.of(name), site.domain.mesh, site.u.function_space
    inside = site.domain.surface(name, quadrature_degree=2 * degree.ufl_element().degree)
    closed_at, ambient = cavity.closed_at_kPa * KPA, AMBIENT_KPA * KPA
    unknown = site.own_unknown(
        f"{name}.pressure_MPa", closed_at - ambient, scale=AIR_SCALE_MPA, multiplier=True
    )
    air = trapped_air.potential(
        unknown.constant,
        site.rest_volume(name),
        site.fixed(closed_at),
        site.fixed(ambient),
        cavity.exponent,
    )
    return cavity_pressure.energy(site.u, mesh, unknown.constant) * inside + site.lumped(air)


Energies = Sequence[StrainEnergy | ReducedIntegration] | ByPart
"""Strain energies of a whole finger, or part by part."""


def total_potential(
    config: Config,
    site: Site,
    solid: Energies,
    loads: Sequence[ufl.Form],
) -> tuple[Potential, Sequence[Term]]:
    """The finger's total potential.

        Π = ∫ ψ dX + ∫ ψ_film dA − p V + Π_effects + Π_loads
            − ∫ ρ g · u dX + Π_plate + Π_contact + Π_friction

    The first line is one term in UFL; residual and tangent are its derivatives. The
    terms of the second line bring their own derivatives.

    Args:
        config: materials, films, effects and how elements are integrated.
        site: the site, with plate and contact if there are any; effects may add friction to them.
        solid: strain energies.
        loads: energies of pressures, effects and inertia, and those that an experiment adds.
    """
    u, mesh, space = site.u, site.domain.mesh, site.u.function_space
    written = Potential(
        u,
        solid,
        loads,
        carried=config.solver.mixed_integration_point,
        p=site.p,
        global_unknowns=list(site.unknowns.values()),
        domain=site.domain,
        sheets=materials.sheets(config, mesh, site.parameters),
        degree=integration_degree(space, full=config.integration != "reduced"),
    )
    terms = (materials.dead_weight(site), site.plate, site.obstacle, site.contact, *site.further)
    return written, [term for term in terms if term is not None]


def build(
    config: Config,
    domain: Domain,
    *,
    plate: bool,
    adds: Adds = nothing,
) -> FingerModel:
    """Build the model of the finger on ``domain``.

    Args:
        config: everything that it depends on.
        domain: reference configuration.
        plate: whether the force sensor's plate faces it.
        adds: what an experiment adds.

    Returns:
        The model, undeformed and without pressure.

    Raises:
        ConfigError: if the configuration asks for something that this experiment does not have.
    """
    config = config.adapted()
    mesh, element = domain.mesh, element_name(config, domain)
    u = fem.Function(fem.functionspace(mesh, displacement_element(element)), name="displacement_mm")
    degree = integration_degree(u.function_space, full=config.integration != "reduced")
    base = materials.BaseMaterial.on(mesh, config.material)
    site = Site(
        config,
        domain,
        u,
        base.mu,
        base.lmbda,
        History(u, degree),
        pressure_field(element, mesh),
        parameters=dict(base.constants),
        pressure=fem.Constant(mesh, PETSc.ScalarType(0.0)),
        set_point=None
        if config.supply is None or config.supply.source == "syringe"
        else SetPoint(),
    )
    surround(site, plate=plate)
    if config.obstacle is not None:
        site.obstacle = beside(site, config.obstacle)
    added = adds(site)
    solid = strain_energies(config, site, base)
    loads = [*pressures(config, site), *config.extensions.terms(site), *added.loads]
    inertia: Inertia | None = None
    if config.experiment.dynamic:
        scheme = config.solver.hht_alpha, config.solver.time_error_mm, added.inertia_from_s
        moving_base = config.base.velocity_mm_s if config.base.time_s else None
        inertia = Inertia(u, domain, materials.densities(site), site.masses, *scheme, moving_base)
        loads.append(inertia.energy)
    motion = [] if inertia is None else [inertia]
    potential, terms = total_potential(config, site, solid, loads)
    controls, supplies = supply(config, site)
    supports = at_rest(u.function_space, site.domain, site.held)
    model = Model(
        site.domain,
        u,
        potential,
        supports,
        {**controls, **added.controls},
        [*terms, *added.terms],
        [site.history, *motion, *supplies, *added.memories],
        p=site.p,
        global_unknowns=added.global_unknowns,
        constraint=moving_clamp(site, supports),
    )
    made = FingerModel(config, site, model, model, model.state(), inertia)
    if config.supply is not None:
        made.supply_air(config.supply)
    elif config.experiment.control == "volume":
        made.control_volume()
    made.rest = made.model.state()
    return made


def strain_energies(config: Config, site: Site, base: materials.BaseMaterial) -> Energies:
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
    energies: dict[tuple[str, ...], list[StrainEnergy | ReducedIntegration]] = {}
    for part in site.domain.parts or (REST,):
        film = next((name for name, other in layers.items() if other.region == part), None)
        if film is not None:
            layer = materials.layer_energy(config, film, layers[film], mesh, site.parameters)
            energies[part,] = [ReducedIntegration(layer)]
            continue
        material = base
        if part != REST:
            material = materials.BaseMaterial.on(mesh, config.material.of(part), f"material.{part}")
            site.parameters |= material.constants
        energy: StrainEnergy = (
            material.of_shape if selective else partial(material.energy, p=site.p)
        )
        volume: list[StrainEnergy] = [material.of_volume] if selective else []
        if part == REST:
            energy = config.extensions.strain_energy(energy, site)
            energy, *volume = config.extensions.in_places([energy, *volume], site)
        energies[part,] = [energy, *map(ReducedIntegration, volume)]
    return energies if site.domain.parts else energies[REST,]


def element_name(config: Config, domain: Domain) -> str:
    """Name of the displacement element; the cells decide it if the configuration does not.

    Raises:
        ConfigError: if the element does not fit the mesh's cells, or an effect has no mixed form.
    """
    cell = str(domain.mesh.ufl_cell())
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
