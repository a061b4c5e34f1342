"""Free bending by dolfingrip with any strain energy, to compare it with its peers."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc
from ufl.core.expr import Expr

from benchmarks import split_energy
from dolfingrip.config import Config
from dolfingrip.experiments import pressures_kPa
from dolfingrip.experiments.rigs.finger import FingerModel, build
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.experiments.rigs.undeformed import load_domain
from dolfingrip.forms import cavity_pressure
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath


def split(config: Config, finger: FingerModel) -> Callable[[Expr], Expr]:
    """The energy of CalculiX with the configuration's moduli."""
    mesh = finger.model.domain.mesh
    mu = fem.Constant(mesh, PETSc.ScalarType(config.material.mu_MPa))
    bulk = config.material.lmbda_MPa + 2 / 3 * config.material.mu_MPa
    kappa = fem.Constant(mesh, PETSc.ScalarType(bulk))
    return lambda strain: split_energy.energy(strain, mu, kappa)


def bend(config: Config, energy: str = "") -> dict[str, Any]:
    """Bend the finger through the configuration's pressures.

    Args:
        config: with ``contact.self_contact = false``, if it is to be compared with peers.
        energy: ``split`` for CalculiX' strain energy, else dolfingrip's own.

    Returns:
        Times by phase (s), numbers of iterations, and the readings by pressure.
    """
    profile = Profile()
    start = time.perf_counter()
    domain = load_domain(config, MPI.COMM_WORLD)
    meshed = time.perf_counter()
    finger = build(config, domain, plate=False)
    model = finger.model
    if energy == "split":
        degree = model.u.function_space.ufl_element().degree
        pressure = model.controls["pressure_kPa"].constant
        cavity = domain.surface("cavity", quadrature_degree=2 * degree)
        model.potential = Potential(
            model.u,
            [split(config, finger)],
            [cavity_pressure.energy(model.u, domain.mesh, pressure) * cavity],
            carried=config.solver.mixed_integration_point,
        )
    observation = Observation(finger)
    newton = Newton(model, config.solver, profile)
    built = time.perf_counter()
    path = LoadPath(newton, {"pressure_kPa": config.solver.max_step_kPa})
    rows = []
    for pressure_kPa in pressures_kPa(config):
        arrival = path.advance({"pressure_kPa": pressure_kPa})
        if arrival.failure is not None:
            raise SystemExit(arrival.failure.sentence())
        if not rows:
            observation.tare()
        rows.append({**observation.read(), "iterations": arrival.iterations})
    solved = time.perf_counter()
    return {
        "dofs": model.dofs,
        "elements": int(domain.mesh.topology.index_map(3).size_global),
        "mesh_s": meshed - start,
        "setup_s": built - meshed,
        "solve_s": solved - built,
        "iterations": newton.counts.iterations,
        "factorisations": newton.counts.factorisations,
        "load_steps": len(rows) - 1,
        "rows": rows,
        "profile": profile.as_dict(),
    }
