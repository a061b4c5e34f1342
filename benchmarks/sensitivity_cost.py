"""The cost of derivatives by all parameters: ``python -m benchmarks.sensitivity_cost``.

Processor time of a run of the default mesh with derivatives of all readings by all parameters at
all stops, as a multiple of the same run without. Forms are compiled before.
"""

from __future__ import annotations

import csv
import sys
import time
from pathlib import Path

from mpi4py import MPI

from benchmarks.sensitivities import INSTRUMENTS, LASTING
from dolfingrip import config as configuration
from dolfingrip.experiments import run
from dolfingrip.experiments.derivatives.sensitivities import chosen

SUPPLIED = ("extensions.pressure_gain={}", "extensions.pressure_offset={}")
ELASTIC = (
    "extensions.mooney_rivlin={}", "extensions.yeoh={}", "extensions.gent={}",
    "extensions.print_anisotropy={}", "extensions.gravity_pitch={}",
    "extensions.wall_offset={}", "extensions.base_layer_offset={}",
    *SUPPLIED, *INSTRUMENTS,
)  # fmt: skip
SPRINGS = (
    "extensions.clamp_compliance={}", "extensions.plate_compliance={}", "extensions.plate_gap={}",
    "extensions.plate_tilt={}", "plate.gap_mm=0.1", "plate.tilt_deg=1",
)  # fmt: skip
CASES = {
    "bending, elastic": ("bending", ELASTIC),
    "blocked force, elastic, on springs": ("blocked_force", (*ELASTIC, *SPRINGS)),
    "bending, elastic, mixed element": ("bending", (*ELASTIC, "extensions.bulk_modulus={}")),
    "bending, one cycle with memory": ("bending", (*LASTING, *ELASTIC, "experiment.unload=true")),
}


def main() -> None:
    """Write the table to the file that is named, ``benchmarks/sensitivity_cost.csv`` by default."""
    file = Path(sys.argv[1] if len(sys.argv) > 1 else "benchmarks/sensitivity_cost.csv")
    with file.open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(["case", "parameters", "without_s", "with_s", "ratio"])
        for case, (experiment, overrides) in CASES.items():
            config = configuration.load(None, overrides)
            short = config.changed(experiment={"max_pressure_kPa": 25.0})
            run(experiment, short, comm=MPI.COMM_SELF, gradients=())  # compiles the forms
            spent = []
            for gradients in (None, ()):
                start = time.process_time()
                result = run(experiment, config, comm=MPI.COMM_SELF, gradients=gradients)
                spent.append(time.process_time() - start)
                assert result.failure is None, result.failure.sentence()
            cells = [f"{spent[0]:.1f}", f"{spent[1]:.1f}", f"{spent[1] / spent[0]:.2f}"]
            table.writerow([case, len(chosen(config, None)), *cells])
            stream.flush()
            print(case, *cells, flush=True)


if __name__ == "__main__":
    main()
