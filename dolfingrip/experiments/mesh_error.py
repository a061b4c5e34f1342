"""The error of a run's readings that is due to its mesh.

The run is made again on a mesh whose cells are bisected. Bisected once more and so on, readings
change by a constant factor less each time, so that the whole error is a multiple of the first
change. Where stress at re-entrant edges rules, the error of a reading falls with h^1.08 (twice the
exponent 0.54 of the displacement at an edge of 270°; Williams, J. Appl. Mech. 19, 1952).

Both runs go through the same stops, so the error of each reading is known at each of them. Parts of
an error may have opposite signs and grow at different rates: the default finger's blocked force is
1.3 % too large at 50 kPa and 1.1 % too small at 250 kPa.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.results.readings import Readings
from dolfingrip.files.run import MeshCheck

ORDER: Final = 1.08
"""Power of the element size that errors fall with."""

ORDER_IN_BLOCKS: Final = 2.0
"""The same of thick blocks, which are integrated selectively: too stiff cells rule there."""

LARGEST: Final = 0.25
"""Largest error of a reading, by the reading's largest value, that is told."""


def whole(config: Config) -> float:
    """The error by the change from one bisection, 1 + r + r² + … of that change.

    Args:
        config: of the run.
    """
    blocks = config.hexahedra and config.integration == "selective"
    return 1 / (1 - 2 ** -(ORDER_IN_BLOCKS if blocks else ORDER))


def bisected(config: Config) -> Config:
    """The configuration with bisected cells.

    Args:
        config: of a run.

    Returns:
        The configuration of the second run.

    Raises:
        ConfigError: one line, where stops are not known beforehand, or cells are divided as often
            as they may be already.
    """
    if config.experiment.control != "pressure":
        raise ConfigError(
            f'experiment.control = "{config.experiment.control}": allowed: "pressure" with '
            "--mesh-check"
        )
    return config.changed(mesh={"refine": 2 * config.mesh.refine})


def estimate(run: Readings, finer: Readings) -> MeshCheck:
    """Estimate the error of all readings of a run.

    Args:
        run: on the mesh as configured.
        finer: the same run on the bisected mesh.

    Returns:
        Errors by column at all rows, or why they cannot be told.
    """
    if len(finer) < len(run):
        ended = "" if finer.failure is None else f": {finer.failure.sentence()}"
        return MeshCheck(why=f"the run on the bisected mesh ends earlier{ended}")
    errors: dict[str, tuple[float, ...]] = {}
    reasons: dict[str, str] = {}
    for name, values in ((column, run[column]) for column in run if column in CHANNELS):
        if values.dtype.kind != "f" or name not in finer:
            continue
        error = -whole(run.config) * (finer[name][: len(run)] - values)
        if not np.isfinite(error).all() or not error.any():
            continue  # such as what both runs prescribe
        if np.abs(error).max() >= LARGEST * np.abs(values).max():
            most = 100 * LARGEST
            reasons[name] = f"the mesh is too coarse: its error is above {most:g} %"
            continue
        errors[name] = tuple(map(float, error))
    return MeshCheck(errors=errors, reasons=reasons)
