"""A short finger's free bending with an effect hidden in it, as a laboratory hands it over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from support import small
from support.measured_files import written

from dolfingrip.config import Config
from dolfingrip.experiments import run

NOISE = {"angle_deg": 0.003, "tip_x_mm": 0.001}
TOLD = """experiment = "bending"
[noise]
angle_deg = 0.003
tip_x_mm = 0.001
[noise.correlated]
angle_deg = 0.0005
tip_x_mm = 0.0002
"""


def config() -> Config:
    """A finger with a graded mesh, and an ungraded one beside it."""
    return small.short("mesh.edge_size_mm=4", "solver.rtol=1e-9")


def measured(
    folder: Path, hidden: Mapping[str, Any], pressures_kPa: Sequence[float], seed: int
) -> Path:
    """A reading each second, simulated on the graded mesh, with noise that is told."""
    print("seed", seed)
    top = int(np.argmax(pressures_kPa))
    branch = ["loading" if i <= top else "unloading" for i in range(len(pressures_kPa))]
    protocol = {"time_s": range(len(branch)), "pressure_kPa": pressures_kPa, "branch": branch}
    truth = run("bending", config().changed(protocol=protocol, extensions=hidden))
    rng = np.random.default_rng(seed)
    columns = [
        truth.column(name) + std * rng.standard_normal(len(branch)) for name, std in NOISE.items()
    ]
    lines = [",".join(["branch", "time_s", "pressure_kPa", *NOISE])]
    lines += [
        f"{way},{i},{pressure},{angle:.6f},{tip:.6f}"
        for i, (way, pressure, angle, tip) in enumerate(
            zip(branch, pressures_kPa, *columns, strict=True)
        )
    ]
    return written(folder, "\n".join(lines) + "\n", TOLD)
