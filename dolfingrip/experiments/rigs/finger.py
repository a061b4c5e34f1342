"""The finger's model, from the configuration alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from dolfingrip.config import KPA, Config
from dolfingrip.experiments.rigs.base_material import BaseMaterial
from dolfingrip.experiments.rigs.films import sheets
from dolfingrip.experiments.rigs.fixture import (
    facing_plate,
    fixed_regions,
    moving_clamp,
    normal_of,
    rigid_plate,
    self_contact,
    supply,
)
from dolfingrip.experiments.rigs.material import (
    element_name,
    pressure_field,
    weight_energy,
    weights_of,
)
from dolfingrip.experiments.rigs.regions import splits, strain_energies
from dolfingrip.extensions.site import Site
from dolfingrip.extensions.supply import Supply
from dolfingrip.forms import cavity_pressure
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import displacement_element, integration_degree
from dolfingrip.mechanics.model.history import History
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.parts import ReducedIntegration, StrainEnergy
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.model.supports import at_rest
from dolfingrip.mechanics.newton.volume_control import volume_controlled


@dataclass(slots=True)
class FingerModel:
    """A pressurised finger, with the plate where one faces it.

    Attributes:
        config: as built, extensions of geometry and set-up applied.
        model: what is solved.
        plate: the force sensor's.
        cavity: the cavity's pressure, which is the regulator's where no extension stands between.
        enclosed: UFL form of the meshed cavity's volume (mm³).
        by_pressure: the model under pressure control; ``model`` itself, unless the control is the
            volume.
        rest: state that readings count from, at first the undeformed one.
        contact: of the skin with itself, where there is any.
        supply: what stands between regulator and cavity, where anything does.
        parameters: constants of the potential by name, that sensitivities are taken to.
        geometric: to be called whenever the mesh has moved.
    """

    config: Config
    model: Model
    plate: RigidPlate | None
    cavity: Control
    enclosed: ufl.Form
    by_pressure: Model
    rest: State
    contact: BarrierContact | None = None
    supply: Supply | None = None
    parameters: dict[str, fem.Constant] = field(default_factory=dict)
    geometric: Sequence[Callable[[], None]] = ()

    def take_over(self, config: Config, rest: np.ndarray) -> None:
        """Put the plate and set the supply's stages as ``config``, adapted, asks for.

        Args:
            config: another one of the same model.
            rest: displacement at rest (local array, mm), from which the plate's gap counts.
        """
        if self.plate is not None:
            self.plate.turn(normal_of(config.plate), config.plate.gap_mm, rest)
        if self.supply is not None:
            self.supply.stages = config.extensions.active("outlet_kPa")


def build(
    config: Config,
    domain: Domain,
    *,
    plate: bool,
    loads: Callable[[Site], Sequence[ufl.Form]] = lambda site: (),
) -> FingerModel:
    """Model of the finger on ``domain``.

    Args:
        config: all that it depends on.
        domain: reference configuration.
        plate: whether the force sensor's plate faces it.
        loads: further energies (mJ of the meshed part), which an experiment adds.

    Raises:
        ConfigError: the configuration asks for what this experiment has not.
    """
    config = config.adapted()
    if plate:
        domain = facing_plate(config, domain)
    base = BaseMaterial.on(domain.mesh, config.material)
    site, p = _site(config, domain, base, plate)
    potential = _potential(config, site, base, p, loads)
    global_unknowns = list(site.unknowns.values())
    sensor, contact = site.plate, site.contact
    if sensor is not None:
        sensor.unknown = next((n for n in global_unknowns if n.constant is sensor.offset), None)
    regulator = Control(site.pressure, KPA)
    stages = supply(config, regulator)
    supports = at_rest(site.u.function_space, domain, site.held)
    model = Model(
        domain,
        site.u,
        potential,
        supports,
        {"pressure_kPa": stages or regulator},
        [term for term in (sensor, contact, *site.further) if term is not None],
        [site.history] if stages is None else [site.history, stages],
        p=p,
        constraint=moving_clamp(site, supports),
    )
    enclosed = _enclosed(site)
    by_volume = config.experiment.control == "volume"
    solved = volume_controlled(model, regulator, enclosed) if by_volume else model
    return FingerModel(
        config,
        solved,
        sensor,
        regulator,
        enclosed,
        model,
        solved.state(),
        contact,
        stages,
        site.parameters,
        site.geometric,
    )


def _potential(
    config: Config,
    site: Site,
    base: BaseMaterial,
    p: fem.Function | None,
    loads: Callable[[Site], Sequence[ufl.Form]],
) -> Potential:
    """Strain energies, loads and what effects add, of the whole solid and its sheets."""
    density = _density(config, base, p, site)
    densities = strain_energies(config, site.domain, density, p, site.parameters)
    terms = [*_loads(site), *config.extensions.terms(site), *loads(site)]
    return Potential(
        site.u,
        densities,
        terms,
        carried=config.solver.mixed_integration_point,
        p=p,
        global_unknowns=list(site.unknowns.values()),
        domain=site.domain,
        sheets=sheets(config, site.domain.mesh, site.parameters),
        degree=_degree(config, site.u.function_space),
    )


def _density(
    config: Config, base: BaseMaterial, p: fem.Function | None, site: Site
) -> list[StrainEnergy | ReducedIntegration]:
    """Strain energy of what has no material of its own, extensions included."""
    if splits(config, p):
        shape = config.extensions.strain_energy(base.of_shape, site)
        return [shape, ReducedIntegration(base.of_volume)]
    return [config.extensions.strain_energy(lambda strain: base.energy(strain, p), site)]


def _site(
    config: Config, domain: Domain, base: BaseMaterial, plate: bool
) -> tuple[Site, fem.Function | None]:
    """The fields, constants and contacts of a model, and the pressure of a mixed element."""
    mesh = domain.mesh
    element = element_name(config, domain)
    space = fem.functionspace(mesh, displacement_element(element))
    u = fem.Function(space, name="displacement_mm")
    pressure = fem.Constant(mesh, PETSc.ScalarType(0.0))
    p = pressure_field(element, mesh)
    site = Site(
        config,
        domain,
        u,
        base.mu,
        base.lmbda,
        plate=rigid_plate(config, domain, u) if plate else None,
        contact=self_contact(config, domain, u) if config.contact.self_contact else None,
        history=History(u, _degree(config, space)),
        held=fixed_regions(domain),
        parameters={**base.constants, **weights_of(config, domain)},
        pressure=pressure,
    )
    return site, p


def _degree(config: Config, space: fem.FunctionSpace) -> int:
    """Degree of the quadrature of strain energies."""
    return integration_degree(space, full=config.integration != "reduced")


def _loads(site: Site) -> list[ufl.Form]:
    """Energies (mJ of the meshed part) of the cavity's pressure and of the weight."""
    degree = site.u.function_space.ufl_element().degree
    cavity = site.domain.surface("cavity", quadrature_degree=2 * degree)
    pressing = cavity_pressure.energy(site.u, site.domain.mesh, site.pressure) * cavity
    return [pressing, *weight_energy(site.config, site.domain, site.u, site.parameters)]


def _enclosed(site: Site) -> ufl.Form:
    """Volume (mm³) of the meshed cavity, integrated exactly."""
    degree = site.u.function_space.ufl_element().degree
    exactly = site.domain.surface("cavity", quadrature_degree=3 * degree)
    return cavity_pressure.volume_density(site.u, site.domain.mesh) * exactly
