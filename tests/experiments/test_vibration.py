"""The finger in time: natural frequencies, and a step of pressure.

References: each other. The ring-down of a small step has the frequency and the place of rest that
the tangent and statics tell.
"""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI
from support import small

from dolfingrip.config import ConfigError
from dolfingrip.experiments import run
from dolfingrip.experiments.request import Request

FREE = (
    "mesh.size_mm=10", "mesh.edge_size_mm=10", "contact.self_contact=false",
    "experiment.step_kPa=20",
)  # fmt: skip
"""Of the short finger, on fewer elements still."""


def test_a_step_of_pressure_swings_about_rest_in_the_first_mode() -> None:
    """A linear oscillator under a sudden load swings from 0 to twice the static value.

    Half a period later than the load it is there; a whole one later it is back.
    """
    still = small.short(*FREE, "experiment.max_pressure_kPa=20", "experiment.rate_kPa_per_s=1e6")
    told = run("vibration", still, comm=MPI.COMM_SELF)
    loaded, frequency = (told.column(name)[-1] for name in ("angle_deg", "frequency_1_Hz"))
    assert np.isfinite([row["frequency_4_Hz"] for row in told.rows]).all()
    half_s = 0.5 / frequency
    times = [0.0, half_s / 100, half_s, 2 * half_s]
    moving = small.short(
        *FREE, "experiment.dynamic=true", f"protocol.time_s={[float(t) for t in times]}",
        "protocol.pressure_kPa=[0.0, 20.0, 20.0, 20.0]", "solver.time_error_mm=0.005",
    )  # fmt: skip
    swung = run("bending", moving, comm=MPI.COMM_SELF).column("angle_deg")
    assert abs(swung[1]) < 0.05 * loaded  # it has had no time to move
    assert swung[2] == pytest.approx(2 * loaded, rel=0.1)
    assert abs(swung[3]) < 0.2 * loaded


def test_refusals() -> None:
    moving = small.short("experiment.dynamic=true")
    with pytest.raises(ConfigError, match="lift_acceleration_m_s2: none; allowed with exp"):
        Request.of("grasp", moving)
    for command in ("coupon", "vibrate"):
        with pytest.raises(ConfigError, match=f"dynamic = true: {command}: allowed: false"):
            Request.of(command, moving)
    with pytest.raises(ConfigError, match='control = volume: allowed with dynamic: "pressure"'):
        small.short("experiment.dynamic=true", 'experiment.control="volume"')
