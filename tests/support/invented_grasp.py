"""Grasps in closed form, for searches of the least pressure or friction that lifts food."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dolfingrip.channels import FINGERS
from dolfingrip.config import Config
from dolfingrip.design.quantities.grasp import READ
from dolfingrip.experiments.request import Answer, Request

WEIGHT_N, PER_KPA, DENSITY_KG_M3 = 0.37, 0.0065, 1000.0


def grasp(config: Config) -> Answer:
    """Invented: normal forces of 0.0065 N for each kPa beyond 5 kPa; friction bears the weight."""
    pressure, mu = config.experiment.max_pressure_kPa, config.food.friction
    normal = PER_KPA * max(pressure - 5.0, 0.0)
    weight = WEIGHT_N * (config.food.density_kg_m3 or DENSITY_KG_M3) / DENSITY_KG_M3
    lifted = mu * normal >= weight
    columns = {
        **{f"normal_{letter}_N": np.full(2, normal / len(FINGERS)) for letter in FINGERS},
        **dict.fromkeys((*READ, "table_z_mm", "contact_pressure_kPa"), np.zeros(2)),
        "force_closure": np.ones(2),
        "table_N": np.array([weight, 0.0 if lifted else weight]),
    }
    kind = "picked up" if lifted else "slipped"
    return Answer(columns, outcome={"kind": kind, "time_s": 1.0, "sentence": ""})


def grasps(requests: Sequence[Request]) -> list[Answer]:
    """Answer requests of grasps."""
    return [grasp(request.config) for request in requests]


def least_kPa(mu: float) -> float:
    """Pressure from which friction ``mu`` bears the weight (kPa)."""
    return WEIGHT_N / (mu * PER_KPA) + 5


def lifts(mu: float, pressure_kPa: float) -> bool:
    """Whether friction ``mu`` bears the weight at a pressure."""
    return mu * PER_KPA * max(pressure_kPa - 5.0, 0.0) >= WEIGHT_N
