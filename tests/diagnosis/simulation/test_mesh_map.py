"""What grading changes, carried to a finger that bends further; no simulation."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.finger.model import MeshMap

PRESSURE_kPa = np.linspace(0, 250, 11)


def test_a_mesh_is_off_by_the_deformation_not_by_the_pressure() -> None:
    """A finger of another modulus, whose mesh is off by 5 % of the square of its angle."""
    true_deg = 140 * (PRESSURE_kPa / 250) ** 1.2
    off_deg = 0.0004 * true_deg**2

    def run(values: np.ndarray) -> Any:
        route = SimpleNamespace(value=tuple(PRESSURE_kPa))
        group = SimpleNamespace(tests=(0,), curve=route)
        result = SimpleNamespace(columns={"angle_deg": values})
        return SimpleNamespace(config=Config(), group=group, schedule=route, result=result)

    measurement = SimpleNamespace(places=lambda tests: {"angle_deg": np.arange(11)})
    plain = true_deg - off_deg
    both = [SimpleNamespace(readings=v, runs=[run(v)]) for v in (true_deg, plain)]
    mapped = MeshMap(cast(Any, measurement), cast(Any, both[0]), cast(Any, both[1]))
    softer_deg = 140 * (PRESSURE_kPa / 250 * 0.9) ** 1.2
    rough_deg = softer_deg - 0.0004 * softer_deg**2
    found, slopes = mapped.to_graded(rough_deg, rough_deg[:, None])
    np.testing.assert_allclose(found, softer_deg, atol=0.02)
    assert np.abs(rough_deg + off_deg - softer_deg).max() > 1.0  # at its pressure
    assert (slopes[1:, 0] > rough_deg[1:]).all()
