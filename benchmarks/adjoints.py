"""Force and angle by all coordinates of the mesh, time and error: ``python -m
benchmarks.adjoints``, with the name of a case for that alone.

Blocked fingers at 250 kPa with self-contact. The time is processor time: of the load path, and of
both adjoints together with their linear solver. Errors are against central differences of
solutions on the moved mesh: along random directions as parts of the derivative's size, along each
dimension as parts of its derivative. Writes ``adjoints.csv``.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.experiments.derivatives.adjoints import FingerAdjoints
from dolfingrip.experiments.rigs.finger import FingerModel, build
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.experiments.rigs.perturbation import Movement, velocities
from dolfingrip.experiments.rigs.undeformed import load_domain, unplaced
from dolfingrip.files import table
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.parameter import Entry, every
from dolfingrip.sections.tables import assignments

HERE = Path(__file__).parent
Floats = NDArray[np.float64]

NAMES = ("force_N", "angle_deg")
PRESSURE_KPA = 250.0
DIRECTIONS, SEED = 20, 33
NEAR_MM, NEAR = 1e-6, 1e-5
"""Step of the differences along a random direction (mm), and along a dimension (of its scale)."""

TIGHT = ("solver.atol_N=1e-10",)
"""Differences of solutions want them to rounding. A second solve has a small first residual."""
CASES = {
    "reference finger": (None, ()),
    "reference finger, gap 1 mm": (None, ("finger.gap_mm=1.0",)),
    "paper's finger": (HERE.parent / "examples" / "paper_finger.toml", ()),
}


class Blocked:
    """A blocked finger at its pressure.

    Attributes:
        finger: at the solution.
        run_s: processor time of the load path (s).
    """

    def __init__(self, config: Config) -> None:
        self.config = config
        self.finger: FingerModel = build(config, load_domain(config, MPI.COMM_SELF), plate=True)
        self._observation = Observation(self.finger)
        self._newton = Newton(self.finger.model, config.solver)
        path = LoadPath(self._newton, {"pressure_kPa": config.solver.max_step_kPa})
        begun = time.process_time()
        pressure = 0.0
        while pressure < PRESSURE_KPA:
            pressure += config.experiment.step_kPa
            failure = path.advance({"pressure_kPa": pressure}).failure
            if failure is not None:
                raise SystemExit(failure.sentence())
        self.run_s = time.process_time() - begun
        self._newton.solve()
        self._start = self.finger.model.state()

    @property
    def touching_N(self) -> float:
        """Largest force of self-contact on a node."""
        contact = self.finger.contact
        if contact is None:
            return 0.0
        forces = contact.gradient(self.finger.model.u.x.array)
        return float(np.linalg.norm(forces, axis=1).max(initial=0.0))

    def adjoints(self) -> FingerAdjoints:
        """Return the adjoints of force and angle."""
        readings = [self._observation.readings[name] for name in NAMES]
        return FingerAdjoints(self.finger, readings, self._newton)

    def difference(self, moving: Floats, step: float) -> Floats:
        """Central difference of the readings along a motion of the mesh."""
        model = self.finger.model
        movement = Movement(model, moving, self.finger.site.geometric)
        ends = []
        for amount in (step, -step):
            model.restore(self._start)
            movement.move(amount)
            model.u.x.array[:] = 0.0
            self._observation.tare()  # the tip's normal on the moved mesh
            model.restore(self._start)
            if not self._newton.solve().converged:
                raise SystemExit("no equilibrium on a moved mesh")
            ends.append([self._observation.readings[name].value() for name in NAMES])
        movement.move(0.0)
        model.u.x.array[:] = 0.0
        self._observation.tare()
        model.restore(self._start)
        return np.asarray(np.subtract(*ends) / (2 * step), dtype=float)


def measure(name: str) -> dict[str, Any]:
    """A row of the table."""
    file, overrides = CASES[name]
    blocked = Blocked(configuration.load(file, assignments(list(overrides))))
    times = []
    for _ in range(3):
        begun = time.process_time()
        _ = blocked.adjoints().by_coordinates
        times.append(time.process_time() - begun)
    row: dict[str, Any] = {
        "case": name,
        "unknowns": blocked.finger.model.u.function_space.dofmap.index_map.size_global * 3,
        "largest_contact_force_N": round(blocked.touching_N, 4),
        "run_s": round(blocked.run_s, 2),
        "first_s": round(times[0], 3),
        "adjoints_s": round(min(times[1:]), 3),
        "adjoints_percent": round(100 * min(times[1:]) / blocked.run_s, 1),
    }
    print(row, flush=True)
    blocked = Blocked(configuration.load(file, assignments([*overrides, *TIGHT])))
    return row | _errors(blocked)


def _errors(blocked: Blocked) -> dict[str, Any]:
    found = blocked.adjoints().by_coordinates
    points = blocked.finger.model.domain.mesh.geometry.x.copy()
    random = np.random.default_rng(SEED)
    largest = 0.0
    sizes = np.array([np.linalg.norm(found[name].owned) for name in NAMES])
    for _ in range(DIRECTIONS):
        moving = random.uniform(-1, 1, points.shape)
        moving[points[:, 1] < 1e-9, 1] = 0.0  # the plane of symmetry stays one
        moving[points[:, 0] < 1e-9] = 0.0  # from the face there the plate's gap counts
        expected = blocked.difference(moving, NEAR_MM)
        slopes = np.array([found[name].along(moving) for name in NAMES])
        largest = max(largest, float(np.abs((slopes - expected) / sizes).max()))
        print(largest, flush=True)
    worst, where = 0.0, ""
    shaped = [each for each in every(blocked.config) if each.entry is Entry.SHAPE]
    flat = unplaced(points, blocked.config)
    for key, moving in velocities(shaped, blocked.config, flat).items():
        (parameter,) = (each for each in shaped if each.key == key)
        expected = blocked.difference(moving, NEAR * parameter.scale)
        slopes = np.array([found[name].along(moving) for name in NAMES])
        off = float(np.abs(slopes / expected - 1).max()) if expected.all() else 0.0
        print(key, slopes, expected, off, flush=True)
        if off > worst:
            worst, where = off, key
    return {
        "error_random_directions": f"{largest:.1e}",
        "error_dimensions": f"{worst:.1e}",
        "worst_dimension": where,
    }


def main(names: Sequence[str]) -> None:
    """Measure some cases, or all."""
    found = []
    for name in names or CASES:
        found.append(measure(name))
        print(found[-1], flush=True)
        table.write(HERE / "adjoints.csv", found)


if __name__ == "__main__":
    main(sys.argv[1:])
