"""Forward sensitivities against central differences of whole runs: ``python -m
benchmarks.sensitivities``.

Each row is one parameter of one case: the largest difference over all readings and stops, as part
of the reading's scale (its largest value in the run, for each ordinary change of the parameter).
The runs that are subtracted have the same mesh, moved, and the same load steps.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from support.differences import (
    BLOCKED,
    COMPLIANT,
    CYCLES,
    ELASTIC,
    HANGING,
    INSTRUMENTS,
    LASTING,
    MOTION,
    RUBBING,
    SHORT,
    STEP,
    STEP_RUBBING,
    SUPPLIED,
    by_parameter,
    derivatives,
    difference,
    error,
)

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.experiments.derivatives.sensitivities import chosen
from dolfingrip.sections.tables import assignments

CASES: Mapping[str, tuple[str, Sequence[str]]] = {
    "bending, elastic": ("bending", (*ELASTIC, *INSTRUMENTS[:3], *HANGING)),
    "blocked, elastic": ("blocked_force", (*BLOCKED, *COMPLIANT, *INSTRUMENTS)),
    "bending, two cycles": ("bending", (*LASTING, *CYCLES)),
    "blocked, two cycles": ("blocked_force", (*LASTING, *CYCLES, *RUBBING)),
    "bending, in motion": ("bending", MOTION),
    "bending, supplied with air": ("bending", SUPPLIED),
}


def settings(case: str) -> tuple[str, Config]:
    """Experiment and configuration of a case."""
    experiment, overrides = CASES[case]
    return experiment, configuration.load(None, assignments([*SHORT, *overrides]))


def main() -> None:
    """Write the table of the cases that are named, or of all, to the file that comes first."""
    file = Path(sys.argv[1] if len(sys.argv) > 1 else "benchmarks/sensitivities.csv")
    with file.open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(["case", "parameter", "largest_error", "column"])
        for case in sys.argv[2:] or CASES:
            experiment, config = settings(case)
            parameters = chosen(config, None)
            base, slopes = derivatives(experiment, config, parameters)
            step = STEP_RUBBING if config.extensions.bellows_friction else STEP
            for parameter in parameters:
                expected = difference(experiment, config, {parameter: parameter.scale}, step)
                found = by_parameter(slopes, parameter.key, parameter.scale)
                worst, column = error(base, found, expected)
                table.writerow([case, parameter.key, f"{worst:.1e}", column])
                stream.flush()
                print(case, parameter.key, f"{worst:.1e}", column, flush=True)


if __name__ == "__main__":
    main()
