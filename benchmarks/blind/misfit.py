"""What the generator's finger leaves without a cause: other elements, and nuisances not linear.

Readings of the generator without noise are fitted with the analyser's nuisances, as large as they
like. What is left, whitened by the analyser's noise and error of the mesh, has a length in standard
deviations: it looks like a cause of that strength.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from benchmarks.blind.alarms import places_of, whole_problem
from benchmarks.blind.diagnoses import How
from benchmarks.blind.response import NUISANCES, Catalogue, Truth
from dolfingrip.diagnosis.fit import Fitter
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.problem import Problem

SIGMAS: Final = (-2.0, -1.0, 1.0, 2.0)


def table(
    catalogue: Catalogue, folder: Path, how: How, show: Callable[[int, int], None]
) -> pd.DataFrame:
    """A row for no nuisance, and for each nuisance and size, the others being 0.

    Args:
        catalogue: the generator's, of the protocol.
        folder: for the measured files.
        how: cases are diagnosed; with workers that stay.
        show: called with the number of fits that are done, and of all.

    Returns:
        ``protocol``, ``nuisance``, ``sigmas`` and ``left_sigma``.
    """
    assert how.crew is not None
    name = catalogue.protocol.name
    whole = whole_problem(catalogue, folder / name, how.crew)
    where = places_of(catalogue, whole)
    wanted = [("none", 0.0), *((each, by) for each in NUISANCES for by in SIGMAS)]
    rows = []
    for number, (nuisance, sigmas) in enumerate(wanted):
        show(number, len(wanted))
        truth = Truth((), {nuisance: sigmas} if sigmas else {})
        problem = replace(whole, value=catalogue.vector(truth)[where])
        fitter = Fitter(problem, how.crew, lambda text: None)
        none = fitter.settled()
        rows.append({
            "protocol": name, "nuisance": nuisance, "sigmas": sigmas,
            "left_sigma": round(_left_sigma(fitter.problem, none), 2),
        })  # fmt: skip
    return pd.DataFrame(rows)


def _left_sigma(problem: Problem, none: Hypothesis) -> float:
    columns = [none.residual(problem.value), none.jacobian, problem.nuisances]
    white = problem.error_covariance.whiten(np.column_stack(columns))
    residual, changes = white[:, 0], white[:, 1:]
    fitted = changes @ np.linalg.lstsq(changes, residual)[0]
    return float(np.linalg.norm(residual - fitted))
