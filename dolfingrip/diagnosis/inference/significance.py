"""Where the simulation is off: the mean residual of groups of readings, with its significance.

In each group the mean is weighted by the noise, w = Σ⁻¹1 / (1ᵀΣ⁻¹1), and its variance is wᵀ C w
with the whole covariance. Generalised least squares with C itself would weight readings negatively
where a nuisance moves them alike, and its "mean" could lie outside the residuals (Peelle's puzzle).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.stats import norm

from dolfingrip.diagnosis.inference.arrays import Matrix, Vector
from dolfingrip.diagnosis.inference.covariance import Covariance
from dolfingrip.diagnosis.inference.multiple import holm

BANDS = 5
FEWEST = 2
"""Readings that a group needs."""
SMALL = 3.0
"""Mean readings below this many standard errors are too near 0 for a relative size."""

Group = tuple[str, dict[str, Any], npt.NDArray[np.bool_]]


def significance_table(
    index: pd.DataFrame,
    measured: Vector,
    residual: Vector,
    noise: Matrix,
    covariance: Covariance,
    edges_kPa: Sequence[float] | None = None,
) -> pd.DataFrame:
    """Mean residuals per channel: in all, by pressure, branch, cycle, rate and specimen.

    Args:
        index: table of the n readings.
        measured: shape (n,).
        residual: measured − simulated, shape (n,).
        noise: Σ, shape (n, n), which the weights come from.
        covariance: C, which errors come from: with nuisances for what they cannot explain,
            without them for what is plainly seen.
        edges_kPa: of the bands of pressure; five equal bands where None.

    Returns:
        A row for each group: ``channel``, ``by``, its ``low_kPa``, ``high_kPa``, ``branch``,
        ``cycle``, ``rate_kPa_per_s``, ``specimen`` (empty where all are meant), ``count``,
        ``simulated_minus_measured`` and ``std_error`` (unit of the channel), ``z``, ``p``,
        ``p_corrected`` (Holm, over all rows), ``percent`` and ``percent_error`` (by the mean
        reading's size; NaN where that is near 0).
    """
    edges = np.asarray(edges_kPa if edges_kPa is not None else _bands(index), dtype=float)
    total = covariance.matrix
    rows = []
    for channel in dict.fromkeys(index["channel"]):
        of_channel = (index["channel"] == channel).to_numpy()
        for by, label, chosen in _groups(index, of_channel, edges):
            numbers = np.flatnonzero(chosen)
            if len(numbers) >= FEWEST:
                row = _mean(numbers, measured, residual, noise, total)
                rows.append({"channel": channel, "by": by, **label, **row})
    columns = ["channel", "by", "low_kPa", "high_kPa", "branch", "cycle", "rate_kPa_per_s",
               "specimen", "count", "simulated_minus_measured", "std_error", "z", "p",
               "p_corrected", "percent", "percent_error"]  # fmt: skip
    table = pd.DataFrame(rows)
    if rows:
        table["p_corrected"] = holm(table["p"].to_numpy())
    return table.reindex(columns=columns)


def _bands(index: pd.DataFrame) -> Vector:
    pressure = index["pressure_kPa"].to_numpy(dtype=float)
    known = pressure[np.isfinite(pressure)]
    if not len(known) or known.max() <= 0:
        return np.zeros(0)
    return np.asarray(np.linspace(0.0, known.max(), BANDS + 1))


def _groups(
    index: pd.DataFrame, of_channel: npt.NDArray[np.bool_], edges: Vector
) -> Iterator[Group]:
    yield "all", {}, of_channel
    pressure = index["pressure_kPa"].to_numpy(dtype=float)
    branches = list(dict.fromkeys(index["branch"][of_channel]))
    for k in range(len(edges) - 1):
        # bands are open below, so that the pose at rest, where nothing can differ, is left out
        inside = of_channel & (pressure > edges[k]) & (pressure <= edges[k + 1])
        band = {"low_kPa": float(edges[k]), "high_kPa": float(edges[k + 1])}
        yield "pressure", band, inside
        for branch in branches:
            of_branch = (index["branch"] == branch).to_numpy()
            yield "pressure and branch", {**band, "branch": branch}, inside & of_branch
    for name in ("branch", "cycle", "rate_kPa_per_s", "specimen"):
        if name not in index.columns:
            continue
        values = index[name][of_channel].dropna().unique()
        if len(values) > 1:
            for value in values:
                yield name, {name: value}, of_channel & (index[name] == value).to_numpy()


def _mean(
    numbers: npt.NDArray[np.intp],
    measured: Vector,
    residual: Vector,
    noise: Matrix,
    total: Matrix,
) -> dict[str, float]:
    """Simulated − measured of one group, with error and significance."""
    block = np.ix_(numbers, numbers)
    weights = np.linalg.solve(noise[block], np.ones(len(numbers)))
    weights /= weights.sum()
    mean = -float(weights @ residual[numbers])
    error = float(np.sqrt(weights @ total[block] @ weights))
    size = abs(float(weights @ measured[numbers]))
    relative = 100 / size if size > SMALL * error else float("nan")
    z = mean / error
    return {
        "count": len(numbers),
        "simulated_minus_measured": mean,
        "std_error": error,
        "z": z,
        "p": float(2 * norm.sf(abs(z))),
        "percent": relative * mean,
        "percent_error": relative * error,
    }
