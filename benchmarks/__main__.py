"""Command line of the benchmark; ``scripts/benchmark`` calls it."""

from __future__ import annotations

import argparse
import shutil
import sys
from typing import Any

from benchmarks import measure, outcomes
from benchmarks.measure import JobError
from benchmarks.outcomes import Outcome
from benchmarks.parts import PARTS, Part, Spec

SCRATCH = measure.ROOT / "out" / "benchmarks"
"""CalculiX' decks and output."""


TIP = ("pressure_kPa", "tip_x_mm", "tip_z_mm", "iterations", "load_steps")
"""Columns that are read from CalculiX' output."""


def say(text: str) -> None:
    """Print progress at once."""
    print(f"benchmark: {text}", flush=True)


def run_calculix(ccx: str, spec: Spec, name: str) -> dict[str, Any]:
    """Write a deck, run it, read the tip; only CalculiX itself is timed."""
    SCRATCH.mkdir(parents=True, exist_ok=True)
    deck = SCRATCH / f"{name}.inp"
    for old in (deck.with_suffix(suffix) for suffix in (".dat", ".sta")):
        old.unlink(missing_ok=True)  # files of an earlier run must not be taken for results
    settings = {**spec, "overrides": [*spec["overrides"], "mesh.order=2"], "deck": str(deck)}
    written = measure.run({**settings, "work": "deck"}, pinned=False)
    timed = measure.run_calculix(ccx, deck)
    read = measure.run({**settings, "work": "tip"}, pinned=False)
    moved = {k: read[k] for k in TIP}
    return {"dofs": written["dofs"], "elements": written["elements"], **moved, **timed}


def run_part(name: str, repeats: int, resume: bool, ccx: str) -> None:
    """Run a part; its outcome is written after every run.

    The labels alternate, so that a busier machine slows all of them alike.
    """
    part: Part = PARTS[name]
    kept = outcomes.read(name) if resume else None
    outcome = kept or Outcome(name)
    versions = measure.run({"work": "versions"}, pinned=False)
    known = ("run_s", "peak_MB", "process_s", "processor_s", "process_processor_s", "load")
    outcome.facts = {
        **outcomes.facts(),
        "versions": {key: value for key, value in versions.items() if key not in known},
    }
    say(f"{name}: {part.title}")
    warm: set[str] = set()
    for repeat in range(min(repeats, part.repeats)):
        for label, spec in part.specs.items():
            done = outcome.runs.setdefault(label, [])
            if len(done) > repeat or (repeat and spec.get("once")):
                continue
            try:
                if spec["work"] == "calculix":
                    if not shutil.which(ccx):
                        if not repeat:
                            say(f"  {label}: skipped, no {ccx} here")
                        continue
                    run = run_calculix(ccx, spec, name)
                else:
                    if label not in warm and not done:
                        warm_up(spec)
                        warm.add(label)
                    run = measure.run(spec)
            except JobError as error:
                say(f"  {label}: failed: {error}")
                continue
            done.append(run)
            outcome.write()
            say(f"  {label}: {summary(run)}")


def warm_up(spec: Spec) -> None:
    """Compile the forms that a run needs, on a coarse mesh and a little pressure."""
    if spec["work"] == "felupe":
        return
    if spec["work"] == "cook":
        measure.run({**spec, "cells": 2})
        return
    kept = [o for o in spec["overrides"] if not o.startswith(("mesh.", "experiment."))]
    half = [o for o in spec["overrides"] if o.startswith("mesh.half")]
    small = ["mesh.size_mm=6", "experiment.max_pressure_kPa=5", "experiment.step_kPa=5"]
    measure.run({**spec, "overrides": [*kept, *half, *small]})


def summary(run: dict[str, Any]) -> str:
    """One line on a run."""
    words = [f"{run.get('run_s', run['process_s']):.1f} s"]
    words.append(f"{run['processor_s']:.1f} s of processor")
    words += [f"{run[key]} {key.replace('_', ' ')}" for key in ("iterations", "dofs") if key in run]
    if "peak_MB" in run:
        words.append(f"{run['peak_MB']:.0f} MB")
    return ", ".join([*words, f"load {run['load'][0]:.1f}"])


def main() -> None:
    """Run the parts asked for and write the results of all that have been run."""
    parser = argparse.ArgumentParser(
        prog="scripts/benchmark",
        description="Benchmarks; parts: " + "; ".join(f"{k} ({p.title})" for k, p in PARTS.items()),
    )
    parser.add_argument("--only", metavar="PART,…", help="parts to run; default: all")
    parser.add_argument("--repeats", type=int, default=5, metavar="N", help="default: 5")
    parser.add_argument("--resume", action="store_true", help="keep runs that were made before")
    parser.add_argument("--ccx", default="ccx", metavar="COMMAND", help="CalculiX; default: ccx")
    parser.add_argument("--results", action="store_true", help="run nothing, write the results")
    asked = parser.parse_args()
    names = asked.only.split(",") if asked.only else list(PARTS)
    for name in names:
        if name not in PARTS:
            parser.error(f"--only {name}: allowed: {', '.join(PARTS)}")
    if asked.repeats < 1:
        parser.error(f"--repeats {asked.repeats}: allowed: 1 or more")
    if not asked.results:
        for name in names:
            run_part(name, asked.repeats, asked.resume, asked.ccx)
    from benchmarks import plots, results

    found = outcomes.read_all(PARTS)
    folder, pictures = outcomes.FOLDER, outcomes.FOLDER
    if found.keys() == PARTS.keys():  # else what is committed has more
        folder, pictures = measure.ROOT / "benchmarks", measure.ROOT / "docs"
    page = folder / "results.md"
    plots.draw(found, pictures)
    results.write(found, page, pictures)
    say(f"wrote {page}")


if __name__ == "__main__":
    sys.exit(main())
