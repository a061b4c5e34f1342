"""Food that bounces between two barriers: steps resolve them, so that it gains no energy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from dolfingrip.experiments.rigs.gripper import RESOLVED
from dolfingrip.forms.inertia import scheme
from dolfingrip.mechanics.contact.density import Smooth
from dolfingrip.mechanics.model.time_integrator import TimeIntegrator

WIDTH_MM, MASS_KG, APART_MM = 0.4, 0.0375, 1.2
BARRIER = Smooth(WIDTH_MM, 0.05)


def most_energy(part: float, area_mm2: float, speed: float) -> float:
    """Largest energy in 0.2 s by that at the start; errors are a part of the barrier's width."""
    motion = TimeIntegrator("food", np.array([APART_MM / 2]), scheme(-0.05))
    motion.start(np.array([speed]), np.zeros(1))

    def gaps(place: float) -> np.ndarray:
        return np.array([place, APART_MM - place])

    def residual(place: float) -> float:
        """By the place (N)."""
        slopes = area_mm2 * BARRIER.at(gaps(place)).slope
        pull = 1e-3 * MASS_KG * motion.stiffness * (place - float(motion.ahead[0]))
        return pull + float(slopes[0] - slopes[1])

    step_s, time_s, found = 1e-4, 0.0, []
    while time_s < 0.2:
        motion.set_step(step_s)
        places = np.array([brentq(residual, 1e-9, APART_MM - 1e-9, xtol=1e-13)])
        error = motion.error_mm(places) / (part * WIDTH_MM)
        if error <= 1:
            motion.accept(places)
            time_s += step_s
            kinetic = 5e-4 * MASS_KG * float(motion.velocity[0]) ** 2
            found.append(
                kinetic + area_mm2 * float(BARRIER.at(gaps(float(places[0]))).energy.sum())
            )
        step_s = min(step_s * min(max(0.9 * max(error, 1e-9) ** (-1 / 3), 0.5), 2.0), 0.1)
    return max(found) / (5e-4 * MASS_KG * speed**2)


@pytest.mark.parametrize("area_mm2", [30.0, 300.0])
def test_what_bounces_gains_no_energy(area_mm2: float) -> None:
    """With errors of a hundredth of the barrier's width; with five times as much it does."""
    speeds = (15.0, 30.0, 60.0, 120.0)
    fine, rough = (
        [most_energy(part, area_mm2, speed) for speed in speeds]
        for part in (RESOLVED, 5 * RESOLVED)
    )
    print(fine, rough)
    assert max(fine) < 1.01
    assert max(rough) > 1.1
