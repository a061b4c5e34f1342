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


def config(*overrides: str) -> Config:
    """A finger with a graded mesh, and an ungraded one beside it."""
    return small.short(*small.FEW, "mesh.edge_size_mm=4", "solver.rtol=1e-9", *overrides)


def measured(
    folder: Path,
    hidden: Mapping[str, Any],
    pressures_kPa: Sequence[float],
    seed: int,
    noise: Mapping[str, float] = NOISE,
    markers: int = 0,
) -> Path:
    """A reading each second, simulated on the graded mesh, with noise that is told."""
    print("seed", seed)
    top = int(np.argmax(pressures_kPa))
    branch = ["loading" if i <= top else "unloading" for i in range(len(pressures_kPa))]
    protocol = {"time_s": range(len(branch)), "pressure_kPa": pressures_kPa, "branch": branch}
    seen = config(f"camera.markers={markers}")
    truth = run("bending", seen.changed(protocol=protocol, extensions=hidden))
    rng = np.random.default_rng(seed)
    columns = [
        truth.column(name) + std * rng.standard_normal(len(branch)) for name, std in noise.items()
    ]
    lines = [",".join(["branch", "time_s", "pressure_kPa", *noise])]
    for i, (way, pressure, *values) in enumerate(zip(branch, pressures_kPa, *columns, strict=True)):
        lines.append(f"{way},{i},{pressure}," + ",".join(f"{value:.6f}" for value in values))
    told = ['experiment = "bending"', "[noise]"]
    told += [f"{name} = {std}" for name, std in noise.items()]
    told += ["[noise.correlated]", *(f"{name} = {std / 5}" for name, std in noise.items())]
    if markers:
        told += ["[camera]", f"markers = {markers}"]
    return written(folder, "\n".join(lines) + "\n", "\n".join(told) + "\n")
