"""Grasps in closed form, for searches of the least pressure or friction that lifts food."""

from __future__ import annotations

from typing import Any

from dolfingrip.design.quantities.quantity import Outcome

WEIGHT_N, PER_KPA, DENSITY_KG_M3 = 0.37, 0.0065, 1000.0


def grasp(config: dict[str, Any], quantities: tuple[str, ...], ranks: int) -> Outcome:
    """Invented: normal forces of 0.0065 N for each kPa beyond 5 kPa; friction bears the weight."""
    pressure, mu = config["experiment"]["max_pressure_kPa"], config["food"]["friction"]
    normal = PER_KPA * max(pressure - 5.0, 0.0)
    weight = WEIGHT_N * (config["food"].get("density_kg_m3") or DENSITY_KG_M3) / DENSITY_KG_M3
    outputs = {
        "picked_up": float(mu * normal >= weight),
        "normal_N": normal,
        "weight_N": weight,
        "outcome_s": 1.0,
        "margin": 1.0,
    }
    return Outcome(outputs, curve={"outcome": "picked up" if outputs["picked_up"] else "slipped"})


OBJECTIVE = "support.invented_grasp:grasp"


def least_kPa(mu: float) -> float:
    """Pressure from which friction ``mu`` bears the weight (kPa)."""
    return WEIGHT_N / (mu * PER_KPA) + 5


def lifts(mu: float, pressure_kPa: float) -> bool:
    """Whether friction ``mu`` bears the weight at a pressure."""
    return mu * PER_KPA * max(pressure_kPa - 5.0, 0.0) >= WEIGHT_N
