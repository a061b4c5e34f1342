"""A design under the extended model of a diagnosis, robust against walls and modulus.

The shipped coupons of printed NinjaFlex are diagnosed on the paper's finger, which gives an
``extended.toml``. Four numbers of the finger are improved under it: as it stands, and for the worst
of ±0.1 mm of wall and ±10 % of the modulus, from several random starts. The same is done under the
model as configured.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.config import ConfigError
from dolfingrip.design import rows
from dolfingrip.design.gradient import run
from dolfingrip.design.gradient.problem import Problem
from dolfingrip.design.gradient.read import read
from dolfingrip.diagnosis.diagnose import Settings, diagnose
from dolfingrip.diagnosis.results import write
from dolfingrip.jobs.pool import Pool

HERE = Path(__file__).parent
EXAMPLES = HERE.parent / "examples"
FINGER = EXAMPLES / "paper_finger.toml"
COUPONS = EXAMPLES / "coupons" / "ninjaflex_uniaxial.csv"
TRIED = ("mooney_rivlin", "gent", "force_gain")
"""Effects without memory: those with memory have no gradient."""

STARTS, SEED = 4, 33
FILE = """
config = "{config}"

[objective]
maximise = "force_N"
at_pressure_kPa = 250.0

[[constraints]]
of = "cog_offset_mm"
at_most = 3.0

[[constraints]]
of = "mass_g"
at_most = 27.7

[[constraints]]
of = "least_wall_mm"
at_least = 0.8

[[constraints]]
of = "least_gap_mm"
at_least = 1.2

[parameters]
morph.xi1 = [-0.2, 1.0]
morph.xi2 = [-0.5, 1.0]
finger.wall_mm = [1.0, 2.2]
finger.base_layer_mm = [2.5, 5.0]

[method]
simulations = {simulations}
"""
CONDITIONS = """
[[scenarios]]
config = "{config}"
change = ["finger.wall_mm=0.1"]
[[scenarios]]
config = "{config}"
change = ["finger.wall_mm=-0.1"]
[[scenarios]]
config = "{config}"
change = ["material.mu_MPa={part}"]
[[scenarios]]
config = "{config}"
change = ["material.mu_MPa=-{part}"]
"""
DESIGNS = 20
"""Largest number of designs of one problem."""


def extended(out: Path) -> Path:
    """The extended model of the coupons, on the paper's finger."""
    found = diagnose(
        [COUPONS], configuration.load(FINGER, []), out, Settings(quick=True, effects=TRIED)
    )
    write(found, [COUPONS], out)
    return out / "extended.toml"


def problem(config: Path, file: Path, *, robust: bool) -> Problem:
    """The problem under one model."""
    text = FILE.format(config=config.resolve(), simulations=DESIGNS * (5 if robust else 1))
    if robust:
        part = 0.1 * configuration.load(config, []).material.mu_MPa
        text += CONDITIONS.format(config=config.resolve(), part=round(part, 4))
    file.write_text(text, encoding="utf-8")
    return read(file)


def robust(out: Path, pool: Pool) -> list[dict[str, Any]]:
    """A row for each model, set of conditions and start."""
    model = extended(out / "diagnosis")
    table: list[dict[str, Any]] = []
    for name, config in (("extended", model), ("as configured", FINGER)):
        for worst in (True, False):
            asked = problem(config, out / "design.toml", robust=worst)
            random = np.random.default_rng(SEED)
            for start in range(STARTS):
                drawn = [float(random.uniform(each.low, each.high)) for each in asked.variables]
                variables = tuple(
                    replace(each, start=value)
                    for each, value in zip(asked.variables, drawn, strict=True)
                )
                if start and not (worst and config is model):
                    continue  # the other problems are for comparison
                row: dict[str, Any] = {
                    "model": name,
                    "conditions": "walls and moduli" if worst else "nominal",
                    "start": start,
                }
                row |= _solved(replace(asked, variables=variables), out / "designs", pool)
                table.append(row)
                print(row, flush=True)
                rows.write(HERE / "design_robust.csv", table)
    return table


def _solved(asked: Problem, out: Path, pool: Pool) -> dict[str, Any]:
    try:
        found = run.solve(asked, run.computed_in(out, pool), lambda trial, limits: None)
    except ConfigError as error:
        return {"ending": str(error)}
    best = found.best
    return {
        "ending": found.ending,
        "simulations": found.simulations,
        "start_N": round(found.start.objective, 4),
        "best_N": round(best.objective, 4),
        "nominal_N": round(asked.sign * float(best.signed[0]), 4),
        "cog_offset_mm": round(best.limits[0], 4),
        "mass_g": round(best.limits[1], 4),
        "least_wall_mm": round(best.limits[2], 4),
        "least_gap_mm": round(best.limits[3], 4),
        **{
            each.key: round(float(value), 4)
            for each, value in zip(asked.variables, best.values, strict=True)
        },
    }
