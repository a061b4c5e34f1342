"""The finger's model, from the configuration alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.config import KPA, Config, ConfigError, Plate
from dolfingrip.experiments.rigs.clamp import held_regions, moving_clamp
from dolfingrip.experiments.rigs.films import sheets
from dolfingrip.experiments.rigs.regions import REST, strain_energies, weighed
from dolfingrip.extensions.site import Site
from dolfingrip.extensions.supply import Supply
from dolfingrip.forms import cavity_pressure, gravity, mixed_neo_hookean, neo_hookean
from dolfingrip.mechanics.contact.barrier import BarrierContact
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.contact.surface import Surface
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.element import CELL, displacement_element, integration_degree
from dolfingrip.mechanics.model.history import History
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.model.supports import at_rest
from dolfingrip.mechanics.newton.volume_control import led_by_volume

KG_M3_M_S2 = 1e-9
"""N/mm³ per kg/m³ · m/s²."""


@dataclass(slots=True)
class FingerModel:
    """A pressurised finger, with the plate where one faces it.

    Attributes:
        config: as built, extensions of geometry and set-up applied.
        model: what is solved.
        plate: the force sensor's.
        cavity: the cavity's pressure, which is the regulator's where no extension stands between.
        enclosed: UFL form of the meshed cavity's volume (mm³).
        by_pressure: the same model led by pressure: ``model`` itself, unless that is led by volume.
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
        domain = _facing_plate(config, domain)
    mesh = domain.mesh
    name = _element(config, domain)
    if name == "P2-P1":
        _refuse_unmixed(config)
    space = fem.functionspace(mesh, displacement_element(name))
    degree = space.ufl_element().degree
    u = fem.Function(space, name="displacement_mm")
    mu = fem.Constant(mesh, PETSc.ScalarType(config.material.mu_MPa))
    lmbda = fem.Constant(mesh, PETSc.ScalarType(config.material.lmbda_MPa))
    pressure = fem.Constant(mesh, PETSc.ScalarType(0.0))

    p = pressure_field(name, mesh)
    cavity = domain.surface("cavity", quadrature_degree=2 * degree)
    terms = [cavity_pressure.energy(u, mesh, pressure) * cavity]
    weights = weights_of(config, domain)
    if any(np.any(each.value) for each in weights.values()):
        terms += weighed(domain, weights, lambda each: gravity.energy(u, each), degree)
    sensor = _plate(config, domain, u) if plate else None
    contact = _contact(config, domain, u) if config.contact.self_contact else None
    rule = integration_degree(space, full=config.full_integration)
    history = History(u, rule)
    known = {
        "material.mu_MPa": mu,
        "material.lmbda_MPa": lmbda,
        **{weight_name(part): each for part, each in weights.items()},
    }
    site = Site(
        config,
        domain,
        u,
        mu,
        lmbda,
        history,
        sensor,
        held_regions(domain),
        known,
        pressure=pressure,
        contact=contact,
    )
    density = config.extensions.strain_energy(
        lambda strain: strain_energy(strain, p, mu, lmbda), site
    )
    densities = strain_energies(
        config, domain, density, lambda strain, *moduli: strain_energy(strain, p, *moduli), known
    )
    terms += [*config.extensions.terms(site), *loads(site)]
    numbers = list(site.unknowns.values())
    if sensor is not None:
        sensor.number = next((n for n in numbers if n.constant is sensor.offset), None)
    further = [term for term in (sensor, contact, *site.further) if term is not None]
    by_pressure = Control(pressure, KPA)
    supply = _supply(config, by_pressure)
    supports = at_rest(space, domain, site.held)
    model = Model(
        domain,
        u,
        Potential(
            u,
            densities,
            terms,
            carried=config.solver.mixed_integration_point,
            p=p,
            numbers=numbers,
            domain=domain,
            sheets=sheets(config, mesh, known),
            degree=rule,
        ),
        supports,
        {"pressure_kPa": supply or by_pressure},
        further,
        [history] if supply is None else [history, supply],
        p=p,
        moving=moving_clamp(site, supports),
    )
    exactly = domain.surface("cavity", quadrature_degree=3 * degree)
    enclosed = cavity_pressure.volume_density(u, mesh) * exactly
    led = model
    if config.experiment.control == "volume":
        led = led_by_volume(model, by_pressure, enclosed)
    return FingerModel(
        config,
        led,
        sensor,
        by_pressure,
        enclosed,
        model,
        led.state(),
        contact,
        supply,
        site.parameters,
        site.geometric,
    )


def _contact(config: Config, domain: Domain, u: fem.Function) -> BarrierContact:
    """Contact of the skin with itself."""
    surface = Surface(
        u.function_space, domain, domain.facets("skin", "tip"), config.contact.spacing_mm
    )
    return BarrierContact(surface, config.contact.barrier_mm, config.contact.stiffness_MPa)


def _element(config: Config, domain: Domain) -> str:
    """Name of the displacement element, by the mesh's cells where the configuration has none."""
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


def strain_energy(strain: Expr, p: fem.Function | None, mu: Expr, lmbda: Expr) -> Expr:
    """Energy per reference volume (mJ/mm³) of the printed material, mixed where there is a p."""
    if p is None:
        return neo_hookean.energy(strain, mu, lmbda)
    return mixed_neo_hookean.energy(strain, p, mu, lmbda)


def weights_of(config: Config, domain: Domain) -> dict[str, fem.Constant]:
    """Dead weight per reference volume (N/mm³) as constants, by part."""
    own = [part for part in domain.parts if part in config.material.own]
    return {part: fem.Constant(domain.mesh, weight(config, part)) for part in (REST, *own)}


def weight_name(part: str) -> str:
    """Name of the constant that is a part's dead weight."""
    return "gravity.weight_N_mm3" if part == REST else f"material.{part}.weight_N_mm3"


def weight(config: Config, part: str = REST) -> np.ndarray:
    """Dead weight of a part per reference volume (N/mm³), (3,)."""
    direction = np.asarray(config.gravity.direction, dtype=float)
    size = config.material.of(part).density_kg_m3 * config.gravity.acceleration_m_s2 * KG_M3_M_S2
    return size * direction / np.linalg.norm(direction)


def _facing_plate(config: Config, domain: Domain) -> Domain:
    """``domain`` with the region that the plate may touch."""
    ends = domain.mesh.geometry.x[:, 2].max(initial=-np.inf)
    length = domain.mesh.comm.allreduce(ends, MPI.MAX)
    # a facet that straddles the plate's end does not face it
    start = length - config.plate.contact_length_mm - 1e-6 * length
    facing = domain.with_region("facing plate", ("skin", "tip"), lambda x: x[2] >= start)
    if not domain.mesh.comm.allreduce(len(facing.facets("facing plate"))):
        raise ConfigError(
            f"plate.contact_length_mm = {config.plate.contact_length_mm}: no element of the "
            "mesh is that near to its tip; allowed: longer than the elements there"
        )
    return facing


def normal_of(plate: Plate) -> np.ndarray:
    """(3,) normal of the tilted plate, towards the finger."""
    tilt = np.deg2rad(plate.tilt_deg)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    return np.asarray(turn @ np.asarray(plate.normal, dtype=float))


def _plate(config: Config, domain: Domain, u: fem.Function) -> RigidPlate:
    plate = config.plate
    return RigidPlate(
        u,
        domain,
        "facing plate",
        normal_of(plate),
        gap_mm=plate.gap_mm,
        width_mm=plate.barrier_mm,
        stiffness_MPa=plate.stiffness_MPa,
    )


def _supply(config: Config, cavity: Control) -> Supply | None:
    """What stands between regulator and cavity, where anything does."""
    stages = config.extensions.active("outlet_kPa")
    if stages and config.experiment.control != "pressure":
        raise ConfigError(
            f'extensions.{stages[0].name()}: allowed: with experiment.control = "pressure" only'
        )
    return Supply(cavity, stages) if stages else None
