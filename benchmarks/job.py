"""One run in a separate process: ``python -m benchmarks.job '{"work": "experiment", …}'``.

Prints its outcome as one line of JSON, the last that starts with :data:`MARK`.
"""

from __future__ import annotations

import json
import resource
import sys
import time
from typing import Any

from dolfingrip.sections.tables import assignments

MARK = "OUTCOME "


def peak_MB() -> float:
    """Highest resident memory of this process (MB)."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def experiment(spec: dict[str, Any]) -> dict[str, Any]:
    """An experiment as the command runs it, without files."""
    from dolfingrip import config
    from dolfingrip.experiments import run

    result = run(spec["kind"], config.load(None, assignments(spec["overrides"])))
    if result.failure is not None:
        raise SystemExit(result.failure.sentence())
    phases = result.facts.profile
    before = {name: phases[name]["wall_s"] for name in ("mesh", "forms")}
    wall = result.facts.wall_s or 0.0
    return {
        "dofs": result.facts.mesh.dofs,
        "elements": result.facts.mesh.elements,
        "mesh_s": before["mesh"],
        "setup_s": before["forms"],
        "solve_s": wall - sum(before.values()),
        "iterations": result.facts.newton.iterations,
        "factorisations": result.facts.newton.factorisations,
        "load_steps": result.facts.newton.load_steps,
        "rows": [
            {k: row[k] for k in ("pressure_kPa", "angle_deg", "force_N", "iterations") if k in row}
            for row in result.rows
        ],
        "profile": phases,
    }


def bending(spec: dict[str, Any]) -> dict[str, Any]:
    """Free bending without self-contact, as the peers compute it."""
    from benchmarks.bending import bend
    from dolfingrip import config

    return bend(config.load(None, assignments(spec["overrides"])), spec.get("energy", ""))


def cook(spec: dict[str, Any]) -> dict[str, Any]:
    """Cook's membrane; a load path that ends early is an outcome, too."""
    from support.cook import shear

    return shear(spec["element"], spec["cells"], spec["nu"])


def felupe(spec: dict[str, Any]) -> dict[str, Any]:
    """Free bending by FElupe."""
    from benchmarks.felupe_bending import bend
    from dolfingrip import config

    return bend(config.load(None, assignments(spec["overrides"])), spec["steps"], spec["ordering"])


def deck(spec: dict[str, Any]) -> dict[str, Any]:
    """Write CalculiX' deck."""
    from pathlib import Path

    from benchmarks.calculix import write_deck
    from dolfingrip import config
    from dolfingrip.experiments.rigs.undeformed import solid

    settings = config.load(None, assignments(spec["overrides"]))
    mesh = solid(settings)
    write_deck(Path(spec["deck"]), mesh, settings, **spec.get("controls", {}))
    return {"dofs": 3 * len(mesh.points), "elements": len(mesh.cells)}


def tip(spec: dict[str, Any]) -> dict[str, Any]:
    """Read CalculiX' output."""
    from pathlib import Path

    from benchmarks.calculix import iterations, read_tip
    from dolfingrip import config
    from dolfingrip.experiments.rigs.undeformed import solid

    output = Path(spec["deck"]).with_suffix(".dat")
    settings = config.load(None, assignments(spec["overrides"]))
    part, moved = read_tip(output, solid(settings))
    return {
        "pressure_kPa": part * settings.experiment.max_pressure_kPa,
        "tip_x_mm": float(moved[0]),
        "tip_z_mm": float(moved[2]),
        **iterations(output.with_suffix(".sta")),
    }


def versions(_spec: dict[str, Any]) -> dict[str, Any]:
    """Versions of the software that computes."""
    import felupe as peer

    from dolfingrip.experiments.results import record

    return {**record.versions(), "felupe": peer.__version__}


WORK = {f.__name__: f for f in (experiment, bending, cook, felupe, deck, tip, versions)}


def main() -> None:
    """Do what the first argument asks for; on several ranks rank 0 prints."""
    spec = json.loads(sys.argv[1])
    start, used = time.perf_counter(), time.process_time()
    outcome = WORK[spec["work"]](spec)
    outcome["run_s"] = time.perf_counter() - start
    outcome["processor_s"] = time.process_time() - used
    outcome["peak_MB"] = peak_MB()
    if spec.get("ranks", 1) > 1:
        from mpi4py import MPI

        # pages that the ranks share are counted on each
        outcome["peak_MB"] = MPI.COMM_WORLD.allreduce(outcome["peak_MB"])
        if MPI.COMM_WORLD.rank:
            return
    print(MARK + json.dumps(outcome))


if __name__ == "__main__":
    main()
