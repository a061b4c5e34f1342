"""CPU time of a load step with path-dependent effects, by that of an elastic one.

    scripts/run python -m benchmarks.step_cost [--repeats 3]

Two cycles of the reference finger without contact between bellows; forms are
compiled before the clock starts. Medians; one process, so run it on an idle core.
"""

from __future__ import annotations

import argparse
import time
from statistics import median

from dolfingrip import config
from dolfingrip.experiments.run import Kind, run

OVERRIDES = (
    "contact.self_contact=false",
    "experiment.max_pressure_kPa=100",
    "experiment.cycles=2",
)
CASES = {
    "elastic": (),
    "prony, 1 term": ("extensions.prony={}",),
    "prony, 3 terms": (
        "extensions.prony.g=[0.1, 0.1, 0.1]",
        "extensions.prony.tau_s=[1, 10, 100]",
    ),
    "mullins": ("extensions.mullins={}",),
    "permanent_set": ("extensions.permanent_set={}",),
    "plate_friction": ("extensions.plate_friction={}",),
}


def cost(kind: Kind, overrides: tuple[str, ...]) -> tuple[float, int, int]:
    """CPU seconds a load step, load steps, Newton iterations of one run."""
    marks: list[float] = []
    settings = config.load(None, [*OVERRIDES, *overrides])
    result = run(kind, settings, progress=lambda row: marks.append(time.process_time()))
    assert result.failure is None, result.failure.sentence()
    steps = sum(row["load_steps"] for row in result.rows[1:])
    iterations = sum(row["iterations"] for row in result.rows[1:])
    return (marks[-1] - marks[0]) / steps, steps, iterations


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description="Cost of path-dependent load steps.")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", help="cases, joined by semicolons; default: all")
    asked = parser.parse_args()
    names = ["elastic", *(asked.only.split(";") if asked.only else list(CASES)[1:])]
    print("| case | CPU (s/step) | by elastic | steps | iterations a step | elastic's |")
    print("|---|---|---|---|---|---|")
    elastic: tuple[float, float] = (0.0, 0.0)
    for name in names:
        found = [cost("blocked_force", CASES[name]) for _ in range(asked.repeats)]
        seconds, (_, steps, iterations) = median(each[0] for each in found), found[0]
        rate = iterations / steps
        elastic = (seconds, rate) if name == "elastic" else elastic
        print(
            f"| {name} | {seconds:.3f} | {seconds / elastic[0]:.2f} | {steps} | {rate:.2f} "
            f"| {elastic[1]:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
