"""What the screen's simulations on the ungraded mesh get wrong about the changes by effects.

    scripts/run python -m benchmarks.graded_secants DATA.csv [--effects a,b] [--workers 2]

Simulates effects at their ordinary strength on the graded mesh, too, for the protocol of measured
data. Prints for each effect how far it changes the readings, in standard deviations beside noise
and nuisances, and by which part of that the change is off: on the ungraded mesh, as the screen has
it, and the same corrected by what grading changes at the same angle and force
(:mod:`dolfingrip.diagnosis.simulation.mesh_map`). "Shape" is what is left of it where the strength
is free. Each effect takes one to two minutes of the reference finger, one with memory ten.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis import selection
from dolfingrip.diagnosis.data import measurement as measured
from dolfingrip.diagnosis.diagnose import problem_of
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.simulation.base import simulate_base
from dolfingrip.diagnosis.simulation.mesh_map import MeshMap
from dolfingrip.diagnosis.simulation.walls import simulate_walls
from dolfingrip.diagnosis.workers import staying

EFFECTS: Final = (
    "bulk_modulus", "gent", "mooney_rivlin", "ogden", "print_anisotropy", "clamp_compliance",
    "gravity_pitch", "plate_compliance", "plate_tilt", "no_self_contact",
)  # fmt: skip
"""Without memory, which take a minute or two each."""


def told(off: Vector, change: Vector) -> str:
    """By which part of its length a change is off, and in shape alone; both whitened."""
    found = change + off
    strength = float(change @ found) / float(found @ found)
    length = float(np.linalg.norm(change))
    whole, shape = (float(np.linalg.norm(v)) for v in (off, strength * found - change))
    return f"{whole / length:.2f}, in shape {shape / length:.2f}"


def main() -> None:
    """Simulate, and print a line for each effect."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--effects", default=",".join(EFFECTS))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/graded_secants"))
    options = parser.parse_args()
    config = Config()
    measurement, _ = selection.selected(measured.read([options.data], config), config)
    effects = options.effects.split(",")
    with staying(options.out, options.workers, lambda standing: None) as workers:
        rough = simulate_base(measurement, config, workers, effects=effects)
        fine = simulate_base(measurement, config, workers, effects=effects, same_mesh=True)
        walls = simulate_walls(measurement, rough, workers)
    assert rough.plain is not None
    fitter = Fitter(problem_of(measurement, rough, walls)[0], workers, print)
    covariance, problem = fitter.settled().covariance(fitter.problem), fitter.problem
    meshes = MeshMap(measurement, rough.simulated, rough.plain)
    none = np.zeros((len(rough.readings), 0))
    graded = {each.name: each for each in fine.candidates}
    for each in rough.candidates:
        part, change = each.parts[0], graded[each.name].shapes[0]
        there, _ = meshes.to_graded(rough.plain.readings + part * each.shapes[0], none)
        mapped = (there - rough.readings) / part
        exact, ungraded, corrected = (
            covariance.whiten(problem.take(v))
            for v in (change, each.shapes[0] - change, mapped - change)
        )
        print(
            f"{each.name}: {np.linalg.norm(exact):.1f} σ; ungraded off by {told(ungraded, exact)}; "
            f"corrected {told(corrected, exact)}",
            flush=True,
        )


if __name__ == "__main__":
    main()
