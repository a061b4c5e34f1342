"""A line's lag beside another modulus: on a short finger, hidden in simulated readings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from diagnosis.data.files import written
from diagnosis.simulation.here import Here
from experiments import small

from dolfingrip.config import Config
from dolfingrip.diagnosis.conclude import NONE, conclude, screen
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.diagnose import problem_of
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.simulation import line_lag, modulus
from dolfingrip.diagnosis.simulation.base import BaseSimulation, simulate_base
from dolfingrip.diagnosis.surface import SurfacePoint
from dolfingrip.experiments import run
from dolfingrip.extensions.line_lag import LineLag

UP = tuple(range(0, 61, 5))
PRESSURES_kPa = (*UP, *UP[-2::-1])
TAU_s = 0.5
SOFTER = 0.75
"""Of the modulus: one and a half of the usual standard deviations."""
NOISE_deg = 0.02
SEED = 8
TOLD = f"""experiment = "bending"
[noise]
angle_deg = {NOISE_deg}
"""


def finger() -> Config:
    return small.short("solver.rtol=1e-9")


@pytest.fixture(scope="module")
def measurement(tmp_path_factory: pytest.TempPathFactory) -> Measurement:
    """Simulated with a softer material behind a line, 0.2 s from one reading to the next."""
    print("seed", SEED)
    time_s = [0.2 * i for i in range(len(PRESSURES_kPa))]
    branch = ["loading"] * len(UP) + ["unloading"] * (len(UP) - 1)
    truth = run(
        "bending",
        finger()
        .overridden((*modulus.overrides(finger(), SOFTER), f"extensions.line_lag.tau_s={TAU_s}"))
        .changed(protocol={"time_s": time_s, "pressure_kPa": PRESSURES_kPa, "branch": branch}),
    )
    angle_deg = truth.column("angle_deg")
    angle_deg = angle_deg + NOISE_deg * np.random.default_rng(SEED).standard_normal(len(time_s))
    lines = ["branch,time_s,pressure_kPa,angle_deg"]
    lines += [
        f"{way},{t:.1f},{p},{angle:.6f}"
        for way, t, p, angle in zip(branch, time_s, PRESSURES_kPa, angle_deg, strict=True)
    ]
    folder = tmp_path_factory.mktemp("lag")
    return read([written(folder, "\n".join(lines) + "\n", TOLD)], finger())


@pytest.fixture(scope="module")
def base(measurement: Measurement, tmp_path_factory: pytest.TempPathFactory) -> BaseSimulation:
    store = Here(tmp_path_factory.mktemp("store"))
    return simulate_base(measurement, finger(), store, effects=("line_lag",))


def test_other_moduli_are_exact(
    base: BaseSimulation, measurement: Measurement, tmp_path: Path
) -> None:
    """Against simulations with all moduli changed, with the line and without."""
    softer = modulus.overrides(finger(), SOFTER)
    lag = f"extensions.line_lag.tau_s={TAU_s}"
    protocol = base.simulated.runs[0].group.in_time.protocol()
    with_line, without = (
        run("bending", finger().overridden(each).changed(protocol=protocol)).column("angle_deg")
        for each in ((*softer, lag), softer)
    )
    found = line_lag.change(measurement, base.simulated, LineLag(tau_s=TAU_s), SOFTER)
    change = with_line - without
    print("off by", np.abs(found - change).max(), "of", np.abs(change).max())
    np.testing.assert_allclose(found, change, atol=2e-3 * np.abs(change).max())


def test_a_lag_and_a_modulus_are_found_between_the_simulations(base: BaseSimulation) -> None:
    """The base model's own modulus is far from the truth, as unloading draws it away.

    A fit begins here, without a simulation: its tangent is that at the place that was found.
    """
    problem, _ = problem_of(base.measurement, base)
    fitter = Fitter(problem, Here(Path("nowhere")), print)
    none = fitter.none()
    found = conclude(problem, screen(problem, none), {NONE: none})
    (score,) = found.scores
    point = fitter.on_surface(score, none)
    assert isinstance(point, SurfacePoint)
    (tau_s,) = point.values
    left = problem.covariance.whiten(problem.value - point.readings)
    print("tau", tau_s, "chi2", left @ left, "of", len(left), none.by_key, point.zeta)
    assert tau_s == pytest.approx(TAU_s, rel=0.05)
    assert left @ left < len(left) + 3 * np.sqrt(2 * len(left))
    count = len(none.parameters)
    assert np.abs(point.beside.zeta - point.zeta[:count]).max() < 0.05
    assert np.abs(none.zeta - point.zeta[:count]).max() > 0.2
