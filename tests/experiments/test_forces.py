"""Forces on the finger balance, and the plate's is the derivative of Π."""

from __future__ import annotations

import numpy as np
import pytest
from support import small

from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.meshes.quality import check

PRESSURES_KPA = (10.0, 25.0, 50.0)
WEIGHT = ("gravity.acceleration_m_s2=9.81", "gravity.direction=[0.6, 0, -0.8]")


@pytest.mark.parametrize(("half", "tilt_deg"), [(True, 0.0), (True, -15.0), (False, 15.0)], ids=str)
def test_plate_clamp_and_weight_balance(half: bool, tilt_deg: float) -> None:
    """Clamp, plate and dead weight are all that acts from outside: a closed cavity's pressure
    adds no force. Each is found by itself, so the sum checks the plate's reaction."""
    settings = small.short(
        *WEIGHT, "solver.rtol=1e-8", f"mesh.half={str(half).lower()}", f"plate.tilt_deg={tilt_deg}"
    )
    finger = small.model(settings, plate=True)
    plate = finger.plate
    assert plate is not None
    volume_mm3 = finger.model.domain.copies * check(solid(settings)).volume_mm3
    newtons_per_mm3 = settings.material.density_kg_m3 * 9.81 * 1e-9
    weight = newtons_per_mm3 * volume_mm3 * np.array([0.6, 0.0, -0.8])
    # the two halves' y-forces cancel by symmetry, which one half alone cannot show
    components = [0, 2] if half else [0, 1, 2]
    for _ in small.pressurise(finger, PRESSURES_KPA):
        force = plate.force_N()
        assert force > 0.05
        outside = small.clamp_force_N(finger) + force * plate.normal + weight
        np.testing.assert_allclose(outside[components], 0.0, atol=1e-6 * force)


def test_plate_force_is_the_derivative_of_the_potential() -> None:
    """Central difference of Π in the plate's position, in steps of a 500th of its indentation."""
    finger = small.model(small.short(), plate=True)
    plate, model = finger.plate, finger.model
    assert plate is not None
    step = 1e-5
    for _ in small.pressurise(finger, PRESSURES_KPA):
        at = float(plate.offset.value)
        values = []
        for offset in (at + step, at - step):
            plate.offset.value = offset
            values.append(model.energy())
        plate.offset.value = at
        slope = model.domain.copies * (values[0] - values[1]) / (2 * step)
        assert plate.force_N() == pytest.approx(slope, rel=1e-5)


def test_free_finger_leaves_no_force_on_the_clamp() -> None:
    # the clamp holds what Newton's method leaves, so that it goes beyond the bound
    finger = small.model(small.short("solver.rtol=1e-10"), plate=False)
    for pressure in small.pressurise(finger, PRESSURES_KPA):
        area = finger.config.finger.chamber_width_mm * finger.config.finger.depth_mm
        assert np.abs(small.clamp_force_N(finger)[[0, 2]]).max() < 1e-9 * pressure * 1e-3 * area


def test_a_gap_delays_the_force() -> None:
    finger = small.model(small.short("plate.gap_mm=0.5"), plate=True)
    assert finger.plate is not None
    free = small.model(small.short(), plate=False)
    touched = []
    for pressure, _ in zip(
        small.pressurise(finger, PRESSURES_KPA), small.pressurise(free, PRESSURES_KPA), strict=True
    ):
        travel = -Observation(free).read()["tip_x_mm"]
        touched.append(finger.plate.force_N() > 0)
        assert touched[-1] == (travel > 0.5), pressure
    assert touched[0] is False
    assert touched[-1] is True
