"""Test data only: an analytic stand-in for the finger, with the same trends and invented figures.

The offset of the centre of gravity is linear in both parameters, as a morph makes it; the force is
an invented function that rises with both and saturates, so that the best designs at any offset
lie inside the bounds and are known in closed form.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dolfingrip.design.optimum.pareto import TradeOff
from dolfingrip.design.quantities.quantity import objective
from dolfingrip.design.surrogate.table import Matrix, Table

LOW, HIGH = np.array([-0.2, -0.5]), np.array([1.0, 1.0])
OFFSET_MM, SLOPE_MM = 2.8, np.array([3.95, 3.39])
FORCE_N, GAIN_N = 6.0, np.array([3.4, 1.6])

BEST_DIFFERENCE = float(np.log(GAIN_N[0] * SLOPE_MM[1] / (GAIN_N[1] * SLOPE_MM[0])))
"""ξ1 − ξ2 of every best design inside the bounds: where the gains per offset are equal."""


def outputs(xi: Matrix) -> Matrix:
    """COG offset (mm) and force (N), shape (n, 2), of designs (n, 2)."""
    return np.column_stack([OFFSET_MM + xi @ SLOPE_MM, FORCE_N + (1 - np.exp(-xi)) @ GAIN_N])


def best(cog_mm: float) -> Matrix:
    """The design of greatest force at an offset, shape (2,), for offsets of 2.4 to 7.5 mm."""
    rest = cog_mm - OFFSET_MM + SLOPE_MM[1] * BEST_DIFFERENCE
    xi1 = rest / SLOPE_MM.sum()
    return np.array([xi1, xi1 - BEST_DIFFERENCE])


OBJECTIVES = (objective("cog_offset_mm", "at most"), objective("force_N", "maximise"))
"""The offset is limited, the force is raised."""

TRADE_OFF = TradeOff(outputs, LOW, HIGH, (1.0, -1.0))
"""Both objectives within the bounds."""


def designs(count: int = 208) -> Matrix:
    """Designs spread evenly over the bounds, shape (count, 2): a grid of 16 by 13."""
    first = np.linspace(LOW[0], HIGH[0], 16)
    second = np.linspace(LOW[1], HIGH[1], 13)
    return np.array([(a, b) for a in first for b in second])[:count]


def table() -> Table:
    """208 designs, as many as the paper's."""
    xi = designs()
    return Table(("morph.xi1", "morph.xi2"), ("cog_offset_mm", "force_N"), xi, outputs(xi))


def write_csv(file: Path, failed: int = 0) -> Path:
    """The table as a campaign exports it; the first ``failed`` rows as failed designs."""
    xi = designs()
    values = outputs(xi)
    lines = ["morph.xi1,morph.xi2,cog_offset_mm,force_N,status,failure,wall_s"]
    for row, (x, y) in enumerate(zip(xi, values, strict=True)):
        if row < failed:
            # a failed design may have got far enough for a number: it must not enter the training
            lines.append(f"{x[0]},{x[1]},{y[0]},999.0,failed,did not converge,1.0")
        else:
            lines.append(f"{x[0]},{x[1]},{y[0]},{y[1]},done,,1.0")
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file
