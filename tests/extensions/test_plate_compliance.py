"""A spring in series with the finger."""

from __future__ import annotations

import numpy as np
import pytest
from support import small, trial

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
    # iterative solves round as memory happens to be aligned
    np.testing.assert_allclose(free[0].column("angle_deg"), free[1].column("angle_deg"), rtol=1e-12)


def test_a_step_is_bounded_either_way() -> None:
    """A step away from the plate, taken backwards, leads into it."""
    finger = small.model(trial.configured({PlateCompliance: {}}, *COMMON), plate=True)
    assert finger.plate.unknown is not None
    away = np.zeros_like(finger.model.unknowns.local())
    away[0 : len(finger.model.u.x.array) : 3] = 1.0
    gap = finger.plate.gap_mm()
    assert 0 < gap < 1
    assert finger.model.max_step(away) == (1.0, "")
    back, bound = finger.model.max_step(-away)
    assert back == pytest.approx(0.9 * gap)
    assert bound == "plate"
    # the plate itself, moved towards the finger
    plate = np.zeros_like(away)
    plate[finger.plate.unknown.place] = 1.0
    assert finger.model.max_step(plate) == (back, "plate")
    assert finger.model.max_step(-plate) == (1.0, "")
    assert finger.model.max_step(away + plate) == (1.0, "")
