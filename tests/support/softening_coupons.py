"""Softening coupons in closed form, five of them, whose stiffness scatters by 1.5 %, with noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from support.measured_files import written

from dolfingrip import config
from dolfingrip.config import Config
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.data.measurement import Measurement, read
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.experiments.rigs.uniaxial import Stretching, UniaxialTension
from dolfingrip.sections.tables import assignments

SEED = 4
GAUGE_mm, AREA_mm2 = 33.0, 9.0
TRAVEL_mm = np.linspace(0.4, 16.0, 18)
NOISE_N = 0.02
TOLD = f"""experiment = "coupon"
gauge_length_mm = {GAUGE_mm}
area_mm2 = {AREA_mm2}
[noise]
force_N = {NOISE_N}
"""


def force_N() -> np.ndarray:
    """Of a softening coupon."""
    softening = config.load(None, assignments(["extensions.mooney_rivlin.C01_MPa=1.36"]))
    way = Stretching(list(TRAVEL_mm / GAUGE_mm), list(TRAVEL_mm), 0.02)
    (pulled,) = UniaxialTension(softening).follow({}, [way])
    return np.ravel(pulled.stress_MPa) * AREA_mm2


Jumped = Callable[[str, np.ndarray], np.ndarray]
"""What a test machine shows more (N), by the specimen and its travel (mm)."""


def measured(
    folder: Path,
    late_mm: Mapping[str, float],
    *,
    again: bool = False,
    count: int = 5,
    jumped: Jumped | None = None,
) -> Measurement:
    """Coupons S1 to S5, some of which grip later; with ``again`` a table is in the file twice."""
    print("seed", SEED)
    rng, true = np.random.default_rng(SEED), force_N()
    lines = []
    for name in ("S1", "S2", "S3", "S4", "S5")[:count]:
        travel = TRAVEL_mm - late_mm.get(name, 0.0)
        values = np.interp(travel, np.r_[-9.0, 0.0, TRAVEL_mm], np.r_[0.0, 0.0, true])
        values = values * (1 + 0.015 * rng.standard_normal()) + NOISE_N * rng.standard_normal(18)
        values = values + (jumped(name, TRAVEL_mm) if jumped else 0.0)
        rows = zip(TRAVEL_mm, values, strict=True)
        lines += [f"{name},loading,{x:.4f},{x:.4f},{force:.4f}" for x, force in rows]
    if again:
        lines += [line.replace("S1,", "S6,") for line in lines if line.startswith("S1,")]
    head = "specimen,branch,time_s,displacement_mm,force_N"
    return read([written(folder, "\n".join([head, *lines]) + "\n", TOLD)], Config())


def diagnosed(measurement: Measurement) -> Diagnosis:
    settings = DiagnosisSettings(quick=True, effects=("mooney_rivlin", "yeoh"))
    return diagnose_measurement(measurement, Config(), Workers(Path("nowhere")), settings)
