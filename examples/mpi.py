"""One finger on several processes.

The mesh is divided among the ranks, and each assembles its own elements. Forces, volumes and angles
are sums over all of them. So the answer must not depend on their number, but for round-off. Each
rank gets the same result, and rank 0 prints.

    scripts/run python examples/mpi.py
    scripts/run mpirun -n 2 python examples/mpi.py
"""

from __future__ import annotations

from mpi4py import MPI

from dolfingrip import config
from dolfingrip.config import NO_CHANGE, Change
from dolfingrip.experiments import run

SHORT = {
    "finger.bellows": 2,
    "finger.length_mm": 38,
    "mesh.size_mm": 6,
    "mesh.edge_size_mm": 6,
    "experiment.max_pressure_kPa": 50,
    "experiment.step_kPa": 50,
    "contact.self_contact": False,
    "solver.rtol": 1e-12,
    "solver.atol_N": 1e-11,
}
"""Two bellows on a coarse mesh, iterated until rounding, so that ranks can be compared."""


def main(comm: MPI.Comm = MPI.COMM_WORLD, overrides: Change = NO_CHANGE) -> float:
    """The tip's angle (deg) at 50 kPa, the same on all ranks."""
    result = run("bending", config.load(overrides={**SHORT, **overrides}), comm=comm)
    return float(result.column("angle_deg")[-1])


if __name__ == "__main__":
    angle = main()
    if MPI.COMM_WORLD.rank == 0:
        print(f"{angle:.9f}° on {MPI.COMM_WORLD.size} ranks")
