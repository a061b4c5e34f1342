"""An objective of a campaign in closed form: thick walls pay, but in a softening material."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dolfingrip.design.quantities.quantity import Outcome
from dolfingrip.jobs.job import JobFailure

PATH = "support.invented_force:objective"


def objective(
    config: dict[str, Any], quantities: tuple[str, ...], ranks: int, keys: Sequence[str] = ()
) -> Outcome:
    xi1, xi2 = config["morph"]["xi1"], config["morph"]["xi2"]
    softens = config["extensions"].get("mooney_rivlin") is not None
    if softens and xi2 == 0.5:
        raise JobFailure("limit point", "stopped at 12 kPa")
    pays = -0.2 if softens else 0.3
    force_N = config["material"]["mu_MPa"] * (1 + pays * xi1 + 0.1 * xi2)
    return Outcome({"cog_offset_mm": 2.8 + xi1, "force_N": force_N})
