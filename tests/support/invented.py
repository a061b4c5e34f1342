"""Design files of the short finger, and answers of their requests in closed form."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from support.small import SHORT

from dolfingrip.config import Config
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.parameter import find

TWO = """
[parameters.morph]
xi1 = [-0.2, 1.0]
xi2 = [-0.5, 1.0]
"""
FORCE = """
[objective]
maximise = "force_N"
at_pressure_kPa = 50.0
"""
COG = """
[[constraints]]
of = "cog_offset_mm"
at_most = "start"
"""


def written(folder: Path, text: str, *overrides: str) -> Path:
    """A design file of the short finger."""
    given = json.dumps([*SHORT, *overrides])
    file = folder / "design.toml"
    file.write_text(f"set = {given}\n{text}", encoding="utf-8")
    return file


class Invented:
    """Answers of requests in closed form.

    Args:
        fails: whether a design has no solution.
    """

    def __init__(self, fails: Callable[[Config], bool] = lambda config: False) -> None:
        self.asked: list[str] = []
        self._fails = fails

    def __call__(self, requests: Sequence[Request]) -> list[Answer]:
        return [self._one(request) for request in requests]

    def _one(self, request: Request) -> Answer:
        self.asked.append(request.key)
        config = request.config
        if self._fails(config):
            return Answer(failure_class="limit point", failure="invented")
        parameters = find(config, list(request.gradients)) if request.gradients else []
        values = {name: np.array([getattr(self, name)(config)]) for name in request.columns}
        slopes = {
            (name, each.key): np.array([float(each.derivative(config, getattr(self, name)))])
            for name in request.columns
            for each in parameters
        }
        return Answer(values, slopes, wall_s=1.0)

    @staticmethod
    def force_N(config: Config) -> float:
        """Largest at ξ = (0.3, −0.2), over a bent valley."""
        a, b = config.morph.xi1 - 0.3, config.morph.xi2 + 0.2
        return 3.0 - 2 * a**2 - 20 * (b - a**2) ** 2

    @staticmethod
    def angle_deg(config: Config) -> float:
        return 40.0 - 30 * config.morph.xi1 - 20 * config.morph.xi1**2
