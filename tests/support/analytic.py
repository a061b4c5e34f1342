"""An objective function that takes no time, so that tests can kill many campaigns."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from dolfingrip.design.quantities.quantity import Outcome
from dolfingrip.jobs.job import JobFailure

PATH = "support.analytic:objective"
FAILING = 0.6
"""Designs with ξ1 above this fail."""


SLOPES = {
    "cog_offset_mm": {"morph.xi1": 1.0, "morph.xi2": 2.0},
    "force_N": {"morph.xi1": 1.0, "morph.xi2": -1.0},
}


def objective(
    config: dict[str, Any], quantities: tuple[str, ...], ranks: int, keys: Sequence[str] = ()
) -> Outcome:
    """Closed forms; every start is noted in the file that ``DOLFINGRIP_TEST_LOG`` names."""
    xi1, xi2 = config["morph"]["xi1"], config["morph"]["xi2"]
    log = os.environ.get("DOLFINGRIP_TEST_LOG")
    if log:
        with Path(log).open("a", encoding="utf-8") as file:  # one short write, so never torn
            file.write(f"{xi1!r} {xi2!r} {os.getpid()}\n")
    time.sleep(float(os.environ.get("DOLFINGRIP_TEST_SECONDS", "0")))
    if config["material"]["mu_MPa"] == 6.66:
        os._exit(1)
    if xi1 > FAILING:
        curve = {"force_N": [0.0, 1.0]}
        raise JobFailure("limit point", "stopped at 12 kPa", {"curve": curve})
    outputs = {"cog_offset_mm": 2.8 + xi1 + 2 * xi2, "force_N": 4 + xi1 - xi2 + ranks - 1}
    slopes = {name: {key: each[key] for key in keys} for name, each in SLOPES.items()}
    return Outcome(outputs, slopes, curve={"force_N": [0.0, outputs["force_N"]]}, iterations=3)


def dies(**_: object) -> None:
    """The function of a worker process that dies at its start."""
    os._exit(1)
