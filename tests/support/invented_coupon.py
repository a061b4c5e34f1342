"""A coupon that is simulated, with an error and noise: a measurement whose truth is known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from support.measured_files import written

from dolfingrip.config import load
from dolfingrip.experiments import run
from dolfingrip.sections.tables import assignments

TOLD = """experiment = "coupon"
gauge_length_mm = 33.0
area_mm2 = 9.0
[noise]
force_N = 0.05
displacement_mm = 0.0
[noise.correlated]
force_N = 0.02
"""
WIDTH_NOISE = 0.002
SEED = 7


def white(rng: np.random.Generator, count: int, std_N: float = 0.05) -> np.ndarray:
    return std_N * rng.standard_normal(count)


def made(
    folder: Path,
    *overrides: str,
    wrong: Callable[[np.ndarray], np.ndarray] = np.ones_like,
    noise: Callable[[np.random.Generator, int], np.ndarray] = white,
    told: str = TOLD,
    width: bool = False,
    offset_N: float = 0.0,
) -> Path:
    """A coupon, up and down, simulated, multiplied by what is ``wrong``, and with noise.

    With ``width`` a camera sees how far it narrows, with ``WIDTH_NOISE``.
    """
    config = load(
        None, assignments(["experiment.unload=true", "coupon.step_strain=0.02", *overrides])
    )
    curve = run("coupon", config)
    names = ["time_s", "displacement_mm", "force_N"]
    time_s, travel_mm, force_N = (curve.column(name) for name in names)
    rng = np.random.default_rng(SEED)
    noise_N = noise(rng, len(force_N))
    print("seed", SEED)
    read = [time_s, travel_mm, force_N * wrong(travel_mm / travel_mm.max()) + offset_N + noise_N]
    if width:
        names.append("transverse_strain")
        scatter = WIDTH_NOISE * rng.standard_normal(len(force_N))
        read.append(curve.column("transverse_strain") + scatter)
    rows = zip(*read, strict=True)
    lines = [",".join(names), *(",".join(f"{x:.6g}" for x in row) for row in rows)]
    folder.mkdir(exist_ok=True)
    return written(folder, "\n".join(lines) + "\n", told)
