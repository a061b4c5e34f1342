"""The facts of a run: what is needed to repeat it and to judge it."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Sequence
from typing import Any

import basix
import dolfinx
import petsc4py
from mpi4py import MPI

from dolfingrip import plugins
from dolfingrip.config import Config
from dolfingrip.experiments.results.readings import Readings
from dolfingrip.files.run import MeshCounts, PluginUsed, RunFailure, RunFile, SolverCounts
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.newton.bordered import has_cholesky
from dolfingrip.mechanics.newton.memory import peak_MB
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.version import versions_of

PACKAGES = ("fenics-ffcx", "fenics-ufl", "gmsh", "ipctk", "meshio", "numpy", "scipy")


def versions() -> dict[str, str]:
    """Versions of the software that a run depends on."""
    return {
        **versions_of(),
        "dolfinx": dolfinx.__version__,
        "basix": basix.__version__,
        "petsc4py": petsc4py.__version__,
        **versions_of(*PACKAGES),
    }


def run_file(config: Config, experiment: str, **facts: Any) -> RunFile:
    """Make the ``run.json`` of this process' run.

    Args:
        config: resolved configuration; ``dolfingrip … --config run.json`` repeats the run.
        experiment: its name.
        facts: further fields.

    Returns:
        The content, with the command, the versions and the machine.
    """
    return RunFile(
        command=tuple(sys.argv[1:]),
        config=config.model_dump(mode="json", exclude_none=True),
        experiment=experiment,
        versions=versions(),
        plugins=tuple(
            PluginUsed(module=p.module, path=p.path, digest=p.digest, version=p.version)
            for p in plugins.loaded()
        ),
        machine={"system": platform.platform(), "processors": os.cpu_count()},
        **facts,
    )


def of_run(
    readings: Readings, newton: Newton, profile: Profile, wall_s: float, notes: Sequence[str]
) -> RunFile:
    """Make the ``run.json`` of a run that has ended.

    Args:
        readings: what it read.
        newton: its solver.
        profile: time of each phase.
        wall_s: time that it took (s).
        notes: doubts about the configuration.

    Returns:
        The content, the same on every rank but for the machine.
    """
    model, failure = newton.model, readings.failure
    return run_file(
        readings.config,
        readings.kind,
        complete=failure is None,
        mesh=MeshCounts(
            elements=int(model.domain.mesh.topology.index_map(3).size_global),
            dofs=model.dofs,
            half=model.domain.half,
            single_walls=round(model.domain.single_walls(), 4),
        ),
        newton=SolverCounts(
            iterations=newton.counts.iterations,
            factorisations=newton.counts.factorisations,
            load_steps=sum(row["load_steps"] for row in readings.rows),
            damped_steps=newton.counts.damped,
            linear_solver="iterative" if newton.linear_solver.iterative else "direct",
            factors="CHOLMOD" if has_cholesky(model) else "MUMPS",
            matrix_patterns=newton.tangent.patterns + 1,
        ),
        failure=None
        if failure is None
        else RunFailure(
            kind=str(failure.kind), last_good=failure.last_good, said=failure.sentence()
        ),
        notes=tuple(notes),
        turning_point=readings.turning_point,
        outcome=readings.outcome,
        plate=readings.plate,
        ranks=model.comm.size,
        compiled_for=jit.PROCESSOR,
        wall_s=round(wall_s, 3),
        memory_forecast_MB=round(newton.linear_solver.forecast_MB),
        peak_memory_MB=round(model.comm.allreduce(peak_MB(), MPI.SUM)),
        profile=profile.as_dict(),
    )
