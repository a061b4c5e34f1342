"""Coupons for closed forms: nearly incompressible, or at small strain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI

from dolfingrip import config
from dolfingrip.experiments import Result, run
from dolfingrip.sections.tables import assignments

INCOMPRESSIBLE = ("material.nu=0.49999", "solver.atol_N=1e-7")
"""Errors of the closed forms of order μ/K = 2e-5."""


def pull(*overrides: str) -> Result:
    """The result of pulling the bar with ``overrides``."""
    result = run("coupon", config.load(None, assignments(overrides)), comm=MPI.COMM_SELF)
    assert result.failure is None, result.failure.sentence()
    return result


def protocol(times_s: Sequence[float], travel_mm: Sequence[float]) -> tuple[str, ...]:
    """Overrides that prescribe the crosshead."""
    return (
        f"protocol.time_s={[float(t) for t in times_s]}",
        f"protocol.displacement_mm={[float(d) for d in travel_mm]}",
    )


def stress(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Stretch (–) and nominal stress (MPa) of each reading."""
    return 1 + result.column("nominal_strain"), result.column("nominal_stress_MPa")
