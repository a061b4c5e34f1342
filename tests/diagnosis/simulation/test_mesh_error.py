"""What the mesh of a finger may get wrong, as columns of the covariance; no simulation."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd

from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.errors import of_mesh
from dolfingrip.diagnosis.finger import FingerSimulation
from dolfingrip.diagnosis.policy import Policy

PRESSURES_kPa = np.array([0.0, 50.0, 100.0, 150.0, 200.0])
FREE = np.repeat([True, False], len(PRESSURES_kPa))


def test_each_experiment_is_off_by_another_part_at_small_loads_than_at_large_ones() -> None:
    """Together they are a part of what grading changes."""
    experiment = np.where(FREE, "bending", "blocked_force")
    control = np.tile(PRESSURES_kPa, 2)
    measurement = SimpleNamespace(
        listed=pd.DataFrame({"experiment": experiment, "control": control}), policy=Policy()
    )
    unused = cast("Any", None)
    simulation = FingerSimulation(
        cast("Any", measurement), Config(), unused, {"mesh.edge_size_mm": 4.0}
    )
    plain = np.r_[0.3 * PRESSURES_kPa, 0.01 * PRESSURES_kPa]
    vars(simulation)["first"] = SimpleNamespace(readings=plain)
    vars(simulation)["fine"] = SimpleNamespace(readings=1.1 * plain)
    whole = Policy().mesh_share * 0.1 * plain
    load = control / PRESSURES_kPa[-1]
    columns = of_mesh(simulation.mesh, measurement.listed["experiment"], load)
    np.testing.assert_allclose(columns.sum(axis=1), whole, rtol=1e-12)
    for own in (FREE, ~FREE):
        mine = columns[own][:, columns[own].any(axis=0)]
        assert not columns[~own][:, columns[own].any(axis=0)].any()
        small, large = 1, -1
        for wanted in ((1.0, 0.0), (0.0, 1.0)):  # either end alone may be off
            ends = mine[[small, large]] / whole[own][[small, large], None]
            parts = np.linalg.solve(ends, wanted)
            np.testing.assert_allclose(ends @ parts, wanted, atol=1e-12)
