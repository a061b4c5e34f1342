"""The design space: which numbers of the configuration vary, between what, and at which points."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.stats import qmc

from dolfingrip.config import ConfigError
from dolfingrip.parameter import Parameter, named

Points = Literal["grid", "sobol", "lhs"]
Inputs = dict[str, float | int | str]
"""One point: value by key of the configuration; a choice is a text."""

PAPER = ("morph.xi1=-0.2:1:16", "morph.xi2=-0.5:1:13")
"""The 208 evenly spaced points of the paper."""

MOST = 100_000
"""Designs of one campaign."""

_DIGITS = 12
"""Significant digits of an input: with more, rounding could make two designs of one point."""


@dataclass(frozen=True, slots=True)
class Varied:
    """A parameter that a design varies, and between what.

    Attributes:
        parameter: number of the configuration.
        low, high: bounds, in the parameter's unit; both are included.
        count: of evenly spaced values on a grid; None where the parameter is for samples only.
    """

    parameter: Parameter
    low: float
    high: float
    count: int | None

    @property
    def key(self) -> str:
        """Key of the configuration."""
        return self.parameter.key

    def value(self, share: float) -> float | int:
        """The value at a share in [0, 1] of the range from ``low`` to ``high``."""
        raw = self.low + share * (self.high - self.low)
        if self.parameter.integer:
            return round(raw)
        return float(f"{raw:.{_DIGITS}g}") + 0.0  # no minus zero


def parse(text: str) -> Varied:
    """Read a parameter from ``section.name=low:high`` or ``section.name=low:high:count``.

    Args:
        text: as on the command line.

    Returns:
        The parameter with its bounds.

    Raises:
        ConfigError: one line, where the key is no number of the configuration or a bound lies
            outside its range.
    """
    key, separator, bounds = text.partition("=")
    key, parts = key.strip(), bounds.split(":")
    form = f"--parameter {text}: allowed: section.name=low:high or section.name=low:high:count"
    if not separator or len(parts) not in (2, 3):
        raise ConfigError(form)
    try:
        low, high = (float(part) for part in parts[:2])
        count = int(parts[2]) if len(parts) == 3 else None
    except ValueError:
        raise ConfigError(form) from None
    parameter = named(key, "--parameter")
    for bound in (low, high):
        parameter.check(bound, "--parameter")
    if not low < high:
        raise ConfigError(f"--parameter {text}: allowed: low below high")
    if count is not None and not 2 <= count <= MOST:
        raise ConfigError(f"--parameter {text}: count = {count}: allowed: 2 to {MOST}")
    return Varied(parameter, low, high, count)


def points(
    parameters: Sequence[Varied], kind: Points, number: int | None = None, seed: int = 0
) -> list[Inputs]:
    """The points of a design of experiments, each once.

    Args:
        parameters: at least one.
        kind: ``grid``, every combination of each parameter's ``count`` values, the first
            parameter the slowest; ``sobol``, of which a longer sequence contains a shorter one;
            or ``lhs``, a Latin hypercube.
        number: of samples; None on a grid.
        seed: of the samples.

    Raises:
        ConfigError: one line, where a count is missing or too much.
    """
    repeated = {p.key for p in parameters if sum(q.key == p.key for q in parameters) > 1}
    if repeated:
        raise ConfigError(f"--parameter {min(repeated)}: given twice; allowed: once")
    if kind == "grid":
        shares = _grid(parameters, number)
    else:
        if number is None or not 1 <= number <= MOST:
            raise ConfigError(f"--points {kind}: --number = {number}; allowed: 1 to {MOST}")
        shares = _samples(len(parameters), kind, number, seed)
    designs: list[Inputs] = [
        {p.key: p.value(float(share)) for p, share in zip(parameters, row, strict=True)}
        for row in shares
    ]
    return list({tuple(point.values()): point for point in designs}.values())


def _grid(parameters: Sequence[Varied], number: int | None) -> np.ndarray:
    counts = []
    for parameter in parameters:
        if parameter.count is None:
            raise ConfigError(
                f"--parameter {parameter.key}: a grid needs a count; allowed: low:high:count"
            )
        counts.append(parameter.count)
    if number is not None and number != math.prod(counts):
        raise ConfigError(
            f"--number {number}: the grid has {' x '.join(map(str, counts))} points; "
            "allowed: no number with --points grid, or sobol or lhs"
        )
    if math.prod(counts) > MOST:
        product = " x ".join(map(str, counts))
        raise ConfigError(f"--parameter: a grid of {product} designs; allowed: {MOST} in all")
    axes = [np.linspace(0, 1, count) for count in counts]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(counts))


def _samples(dimensions: int, kind: Points, number: int, seed: int) -> np.ndarray:
    if kind == "lhs":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=seed).random(number))
    with warnings.catch_warnings():
        # a number that is no power of two costs some balance, which is the caller's choice
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(qmc.Sobol(dimensions, rng=seed).random(number))
