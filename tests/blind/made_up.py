"""A finger that is made up, so that no test of the blind benchmark has to simulate one."""

from __future__ import annotations

import numpy as np

from benchmarks.blind import cases, generator
from benchmarks.blind.cases import Case
from benchmarks.blind.generator import Cause
from benchmarks.blind.library import WALL_PARTS, Change, Curve, Library
from benchmarks.blind.protocols import PROTOCOLS
from benchmarks.blind.response import Catalogue, Hidden, Truth

SIMULATED = ("mooney_rivlin", "prony", "plate_compliance")
CLOSED = ("angle_gain", "line_lag")


def few() -> dict[str, Cause]:
    known = generator.causes()
    return {name: known[name] for name in (*SIMULATED, *CLOSED)}


def made_up(protocol: str = "P2") -> Catalogue:
    """A finger that bends and presses as powers of the pressure, and three effects on it."""
    at = np.linspace(0, 375, 31)
    base, walls, changes = {}, {}, {}
    for experiment, column, scale in (
        ("bending", "angle_deg", 100),
        ("blocked_force", "force_N", 3),
    ):
        y = scale * (at / 250 + 0.3 * (at / 250) ** 2)
        slopes = {
            (column, "finger.base_layer_mm"): -0.3 * y,
            (column, "plate.gap_mm"): -0.02 * (experiment == "blocked_force") * at / (at + 20),
        }
        base[experiment] = Curve(at, {column: y, "tip_x_mm": -y / 2, "tip_z_mm": y}, slopes)
        softer = -0.8 * y * (1 - at / 800)
        walls[experiment] = {
            part: Curve(at, dict.fromkeys(base[experiment].columns, y + part * softer), {})
            for part in WALL_PARTS
        }
        rows = PROTOCOLS[protocol].course(experiment).rows
        history = rows["pressure_kPa"].to_numpy()
        up = at[at <= 300]
        shapes = {
            "mooney_rivlin": ("curve", up, np.sin(up / 60) * up / 250),
            "prony": ("history", history, np.where(rows["branch"] == "unloading", 1.0, 0.1)
                      * history * (250 - history) / 250**2),
            "plate_compliance": ("curve", up, (experiment == "blocked_force") * (up / 250) ** 3),
        }  # fmt: skip
        for name, (way, place, shape) in shapes.items():
            for form, each in enumerate(few()[name].forms):
                sizes = np.array([part + 0.1 * part**2 for part in each.parts])
                values = 0.1 * scale * (1 + 0.2 * form) * sizes[:, None] * shape[None, :]
                changes[name, form, experiment] = Change(way, place, each.parts, {column: values})
    return Catalogue(PROTOCOLS[protocol], Library(base, walls, changes), few())


def case(catalogue: Catalogue, *hidden: Hidden, kind: cases.Kind = "one", seed: int = 3) -> Case:
    truth = Truth(hidden, {"modulus": 0.4, "pressure_offset": -0.5, "wall": 1.1})
    return Case("development", 0, catalogue.protocol.name, kind, False, truth, (seed,))
