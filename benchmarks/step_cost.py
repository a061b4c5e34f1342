"""CPU time of a load step with path-dependent effects, by that of an elastic one.

    scripts/run python -m benchmarks.step_cost [--repeats 3]

Two cycles of the reference finger, without contact between bellows to 100 kPa, and with it, for the
friction there, to 200 kPa; forms are compiled before the clock starts. Medians; one process, so run
it on an idle core.
"""

from __future__ import annotations

import argparse
import time
from statistics import median

from dolfingrip import config
from dolfingrip.experiments import run

APART = ("contact.self_contact=false", "experiment.max_pressure_kPa=100", "experiment.cycles=2")
TOUCHING = ("experiment.max_pressure_kPa=200", "experiment.cycles=2")
CASES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "prony, 1 term": (APART, ("extensions.prony={}",)),
    "prony, 3 terms": (
        APART,
        ("extensions.prony.g=[0.1, 0.1, 0.1]", "extensions.prony.tau_s=[1, 10, 100]"),
    ),
    "mullins": (APART, ("extensions.mullins={}",)),
    "permanent_set": (APART, ("extensions.permanent_set={}",)),
    "plate_friction": (APART, ("extensions.plate_friction={}",)),
    "bellows_friction": (TOUCHING, ("extensions.bellows_friction={}",)),
}
"""Overrides of the elastic finger that a case is compared with, and what they gain."""


def cost(kind: str, overrides: tuple[str, ...]) -> tuple[float, int, int]:
    """CPU seconds a load step, load steps, Newton iterations of one run."""
    marks: list[float] = []
    settings = config.load(None, overrides)
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
    names = asked.only.split(";") if asked.only else list(CASES)
    print("| case | CPU (s/step) | by elastic | steps | iterations a step | elastic's |")
    print("|---|---|---|---|---|---|")
    elastic: dict[tuple[str, ...], tuple[float, int, float]] = {}
    for name in names:
        led, gained = CASES[name]
        if led not in elastic:
            elastic[led] = measured(led, asked.repeats)
        seconds, steps, rate = measured((*led, *gained), asked.repeats)
        base, _, usual = elastic[led]
        print(
            f"| {name} | {seconds:.3f} | {seconds / base:.2f} | {steps} | {rate:.2f} "
            f"| {usual:.2f} |",
            flush=True,
        )


def measured(overrides: tuple[str, ...], repeats: int) -> tuple[float, int, float]:
    """Median of the CPU seconds a load step, load steps, Newton iterations a step."""
    found = [cost("blocked_force", overrides) for _ in range(repeats)]
    seconds, (_, steps, iterations) = median(each[0] for each in found), found[0]
    return seconds, steps, iterations / steps


if __name__ == "__main__":
    main()
