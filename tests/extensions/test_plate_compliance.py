"""A spring in series with the finger."""

from __future__ import annotations

import numpy as np
import pytest
from extensions import trial

from dolfingrip.experiments import run
from dolfingrip.extensions.plate_compliance import PlateCompliance

COMMON = (
    *trial.STRICT,
    "contact.self_contact=false",
    "experiment.max_pressure_kPa=50",
    "experiment.step_kPa=25",
)


@pytest.mark.parametrize("compliance", [0.02, 1.0])
def test_spring_in_series(compliance: float) -> None:
    """Gives way by F/k: the same as a rigid plate that stands so much farther away."""
    on = {PlateCompliance: {"compliance_mm_per_N": compliance}}
    found = run("blocked_force", trial.configured(on, *COMMON), comm=trial.SELF)
    assert found.failure is None
    force = found.column("force_N")[-1]
    assert force > 0.3
    gap = f"plate.gap_mm={compliance * force}"
    rigid = run("blocked_force", trial.configured({}, *COMMON, gap), comm=trial.SELF)
    assert rigid.failure is None
    for name in ("force_N", "tip_x_mm", "angle_deg"):
        assert found.column(name)[-1] == pytest.approx(rigid.column(name)[-1], rel=1e-6)


def test_free_bending_has_no_plate() -> None:
    on = {PlateCompliance: {}}
    free = [run("bending", trial.configured(e, *COMMON), comm=trial.SELF) for e in ({}, on)]
    np.testing.assert_array_equal(free[0].column("angle_deg"), free[1].column("angle_deg"))
