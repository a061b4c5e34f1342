"""The finger's model, from the configuration alone."""

from __future__ import annotations

from dataclasses import dataclass

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.config import KPA, Config, ConfigError
from dolfingrip.forms import cavity_pressure, gravity, mixed_neo_hookean, neo_hookean
from dolfingrip.mechanics.contact import BarrierContact
from dolfingrip.mechanics.domain import Domain
from dolfingrip.mechanics.element import CELL, displacement_element
from dolfingrip.mechanics.model import Control, Model
from dolfingrip.mechanics.plate import RigidPlate
from dolfingrip.mechanics.potential import Potential
from dolfingrip.mechanics.surface import Surface
from dolfingrip.mechanics.volume_control import VolumeControl

KG_M3_M_S2 = 1e-9
"""N/mm³ per kg/m³ · m/s²."""


@dataclass(slots=True)
class FingerModel:
    """A pressurised finger, with the plate where one faces it."""

    config: Config
    model: Model
    plate: RigidPlate | None
    volume: VolumeControl | None = None


def build(config: Config, domain: Domain, *, plate: bool) -> FingerModel:
    """Model of the finger on ``domain``, with or without the force-sensor plate."""
    if plate:
        domain = _facing_plate(config, domain)
    mesh = domain.mesh
    name = _element(config, domain)
    space = fem.functionspace(mesh, displacement_element(name))
    degree = space.ufl_element().degree
    u = fem.Function(space, name="displacement_mm")
    mu = fem.Constant(mesh, PETSc.ScalarType(config.material.mu_MPa))
    lmbda = fem.Constant(mesh, PETSc.ScalarType(config.material.lmbda_MPa))
    pressure = fem.Constant(mesh, PETSc.ScalarType(0.0))

    p = pressure_field(name, mesh)
    cavity = domain.surface("cavity", quadrature_degree=2 * degree)
    terms = [cavity_pressure.energy(u, mesh, pressure) * cavity]
    weight = _weight(config)
    if np.any(weight):
        dx = ufl.Measure("dx", mesh, metadata={"quadrature_degree": degree})
        terms.append(gravity.energy(u, fem.Constant(mesh, weight)) * dx)
    sensor = _plate(config, domain, u) if plate else None
    if sensor is not None:
        terms.append(sensor.energy)

    contact = None
    if config.contact.self_contact:
        surface = Surface(space, domain, domain.facets("skin", "tip"), config.contact.spacing_mm)
        contact = BarrierContact(surface, config.contact.barrier_mm, config.contact.stiffness_MPa)
    by_pressure = Control(pressure, KPA)
    model = Model(
        domain,
        u,
        Potential(
            u,
            [lambda strain: strain_energy(strain, p, mu, lmbda)],
            terms,
            carried=config.solver.mixed_integration_point,
            p=p,
        ),
        _supports(space, domain),
        {"pressure_kPa": by_pressure},
        contact,
        [sensor] if sensor is not None else [],
        p=p,
    )
    volume = None
    if config.experiment.control == "volume":
        cavity = domain.surface("cavity", quadrature_degree=3 * degree)
        density = cavity_pressure.volume_density(u, mesh)
        volume = VolumeControl(model, by_pressure, density * cavity)
        model.controls["cavity_volume_mm3"] = volume
    return FingerModel(config, model, sensor, volume)


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


def _weight(config: Config) -> np.ndarray:
    """Dead weight per reference volume (N/mm³), (3,)."""
    direction = np.asarray(config.gravity.direction, dtype=float)
    size = config.material.density_kg_m3 * config.gravity.acceleration_m_s2 * KG_M3_M_S2
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


def _plate(config: Config, domain: Domain, u: fem.Function) -> RigidPlate:
    plate = config.plate
    tilt = np.deg2rad(plate.tilt_deg)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    return RigidPlate(
        u,
        domain,
        "facing plate",
        turn @ np.asarray(plate.normal, dtype=float),
        gap_mm=plate.gap_mm,
        width_mm=plate.barrier_mm,
        stiffness_MPa=plate.stiffness_MPa,
    )


def _supports(space: fem.FunctionSpace, domain: Domain) -> list[fem.DirichletBC]:
    """Clamp fixed; no motion through the symmetry plane."""
    # by component: on a whole blocked space dolfinx 0.9 takes ghosts for owned dofs
    held = {0: ["clamp"], 1: ["clamp"], 2: ["clamp"]}
    if domain.half:
        held[1].append("symmetry")
    supports = []
    for axis, regions in held.items():
        along = space.sub(axis)
        dofs = fem.locate_dofs_topological(along, 2, domain.facets(*regions))
        supports.append(fem.dirichletbc(PETSc.ScalarType(0.0), dofs, along))
    return supports
