"""A film over a chamber's open mouth, as membrane and as layer: ``python -m benchmarks.films``.

One chamber of a cast block, 20 kPa in four readings. A layer resists bending, the less the thinner
it is: 0.02 mm at 1 N/mm, 0.01 mm at the others.
"""

from __future__ import annotations

import time

from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.experiments import run
from dolfingrip.experiments.results.result import Result

THICKNESS_MM = {1.0: 0.02, 50.0: 0.01, 2000.0: 0.01}
"""Of the layer, by Et (N/mm)."""

BLOCK = (
    "finger.kind=cast", "cast.chambers=1", "material.mu_MPa=0.0204", "film.silk.region=film",
    "contact.self_contact=false", "experiment.max_pressure_kPa=20", "experiment.step_kPa=5",
    "solver.max_step_kPa=5", "camera.chord=back edges", "mesh.size_mm=4", "mesh.edge_size_mm=1",
)  # fmt: skip


def bent(stiffness: float, model: str) -> Result:
    """The block with such a film."""
    film = (
        f"cast.film_mm={THICKNESS_MM[stiffness]}", f"film.silk.model={model}",
        f"film.silk.Et_N_per_mm={stiffness}",
    )  # fmt: skip
    return run("bending", configuration.load(None, [*BLOCK, *film]), comm=MPI.COMM_SELF)


def main() -> None:
    """Print a line for each stiffness."""
    for stiffness in THICKNESS_MM:
        angles, iterations, seconds = [], [], []
        for model in ("membrane", "layer"):
            start = time.process_time()
            result = bent(stiffness, model)
            angles.append(result.column("chord_angle_deg")[1:])
            iterations.append([int(each) for each in result.column("iterations")[1:]])
            seconds.append(round(time.process_time() - start, 1))
        apart = ", ".join(f"{a / b - 1:+.1%}" for a, b in zip(*angles, strict=False))
        print(f"Et {stiffness:g} N/mm: membrane against layer {apart}; iterations {iterations[0]} "
              f"and {iterations[1]}; {seconds[0]} and {seconds[1]} s of processor")  # fmt: skip


if __name__ == "__main__":
    main()
