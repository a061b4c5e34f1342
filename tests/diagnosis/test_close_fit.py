"""A fit that begins on the graded mesh, as a surface is close to what a simulation gives there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from diagnosis.data.files import written
from diagnosis.simulation.here import Here
from experiments import small

from dolfingrip.diagnosis.data.measurement import read
from dolfingrip.diagnosis.diagnose import Settings, diagnose_measurement
from dolfingrip.diagnosis.fit import STRAIGHT
from dolfingrip.diagnosis.step import visit
from dolfingrip.experiments import run

WAY = (0, 20, 40, 60, 40, 20, 0)
BRANCH = ("loading",) * 4 + ("unloading",) * 3
NOISE_deg = 0.003
G, TAU_s = 0.28, 4.0
"""Between the values that the screen tries: g = 0.2, τ = 2, 13 and 90 s."""
SEED = 12
TOLD = f"""experiment = "bending"
[noise]
angle_deg = {NOISE_deg}
tip_x_mm = 0.001
[noise.correlated]
angle_deg = 0.0005
tip_x_mm = 0.0002
"""


def test_one_simulation_on_the_graded_mesh_finds_a_viscosity(tmp_path: Path) -> None:
    print("seed", SEED)
    config = small.short("mesh.edge_size_mm=4", "solver.rtol=1e-9")
    protocol = {"time_s": range(len(WAY)), "pressure_kPa": WAY, "branch": BRANCH}
    hidden = {"prony": {"g": [G], "tau_s": [TAU_s]}}
    truth = run("bending", config.changed(protocol=protocol, extensions=hidden))
    rng = np.random.default_rng(SEED)
    angle_deg = truth.column("angle_deg") + NOISE_deg * rng.standard_normal(len(WAY))
    tip_x_mm = truth.column("tip_x_mm") + 0.001 * rng.standard_normal(len(WAY))
    lines = ["branch,time_s,pressure_kPa,angle_deg,tip_x_mm"]
    lines += [
        f"{branch},{i},{pressure},{angle:.6f},{tip:.6f}"
        for i, (branch, pressure, angle, tip) in enumerate(
            zip(BRANCH, WAY, angle_deg, tip_x_mm, strict=True)
        )
    ]
    file = written(tmp_path, "\n".join(lines) + "\n", TOLD)
    settings = Settings(effects=("prony",))
    found = diagnose_measurement(read([file], config), config, Here(tmp_path / "store"), settings)
    fit = found.fits[frozenset(["prony"])]
    estimates = dict(zip(fit.by_key, fit.estimates(found.problem), strict=True))
    print(estimates, "evaluations", fit.evaluations)
    assert fit.evaluations == 1
    for key, hidden_value in (("g", G), ("tau_s", TAU_s)):
        told = estimates[f"extensions.prony.{key}"]
        wide = told.high - told.low
        assert told.low - 0.5 * wide < hidden_value < told.high + 0.5 * wide

    # Reference: a simulation where the step along the tangent ended.
    assert fit.model is not None
    there = visit(found.problem, fit.model.evaluate, fit.model, fit.zeta)
    off = found.problem.covariance.whiten(there.readings - fit.readings)
    print("off the tangent by", np.linalg.norm(off))
    assert np.linalg.norm(off) < 2 * STRAIGHT
