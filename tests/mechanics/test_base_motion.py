"""A base that moves: a sudden acceleration, by statics and the natural frequency."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI
from support import small

from dolfingrip.config import ConfigError
from dolfingrip.experiments import run
from dolfingrip.experiments.request import Request
from dolfingrip.sections.base_motion import BaseMotion

FREE = ("mesh.size_mm=10", "mesh.edge_size_mm=10", "contact.self_contact=false",
        "experiment.step_kPa=1", "experiment.max_pressure_kPa=1")  # fmt: skip
RATE_m_s2 = 10.0


@pytest.mark.slow
def test_a_sudden_acceleration_swings_about_the_sag() -> None:
    """It goes to twice the sag under a weight of the same acceleration, and back in a period."""
    hangs = small.short(
        *FREE, f"gravity.acceleration_m_s2={RATE_m_s2}", "gravity.direction=[-1,0,0]"
    )
    sag_mm = run("bending", hangs, comm=MPI.COMM_SELF).facts.sag_mm[0]
    assert sag_mm < -0.001
    frequency = run("vibration", small.short(*FREE), comm=MPI.COMM_SELF).column("frequency_1_Hz")[0]
    times = [0.0, 0.25 / frequency, 0.5 / frequency, 1 / frequency]
    moving = small.short(
        *FREE, "experiment.dynamic=true", f"protocol.time_s={[float(t) for t in times]}",
        "protocol.pressure_kPa=[0,0,0,0]", f"solver.time_error_mm={float(-sag_mm / 1000)}",
        f"base.time_s=[0, {float(times[-1])}]",
        f"base.acceleration_m_s2=[{RATE_m_s2}, {RATE_m_s2}]",
    )  # fmt: skip
    tip_mm = run("bending", moving, comm=MPI.COMM_SELF).column("tip_x_mm")
    np.testing.assert_allclose(tip_mm / sag_mm, [0, 1, 2, 0], atol=0.15)


def test_velocity_is_the_integral_of_the_acceleration() -> None:
    """0 before and after; of a line from 0 to a it is a t²/(2 T)."""
    base = BaseMotion(time_s=(1.0, 3.0, 4.0), acceleration_m_s2=(0.0, 2.0, -2.0),
                      direction=(0.0, 0.0, -2.0))  # fmt: skip
    found = [base.velocity_mm_s(t)[2] for t in (0.0, 1.0, 2.0, 3.0, 3.5, 4.0, 9.0)]
    np.testing.assert_allclose(found, [0, 0, -500, -2000, -2500, -2000, -2000], atol=1e-9)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        (("base.time_s=[0, 1]", "base.acceleration_m_s2=[0, 1]"), "allowed: with exp.*dynamic"),
        (("base.time_s=[0, 1]",), "acceleration_m_s2 = 0 values: allowed: as many"),
        (("base.time_s=[1, 1]", "base.acceleration_m_s2=[0, 1]"), "each after the one before"),
    ],
)
def test_refusals(keys: tuple[str, ...], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        small.short(*keys)


def test_a_grasp_has_a_base_at_rest() -> None:
    moving = small.short(
        "experiment.dynamic=true", "gripper.lift_acceleration_m_s2=1", "base.time_s=[0, 1]",
        "base.acceleration_m_s2=[0, 1]",
    )  # fmt: skip
    with pytest.raises(ConfigError, match=r"base.time_s: a grasp has a base at rest"):
        Request.of("grasp", moving)
