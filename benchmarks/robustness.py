"""Robustness table: random fingers, free and blocked, each pressurised to 300 kPa.

    scripts/robustness [--number 200] [--seed 0] [--workers 1] [--out out/robustness]
                       [--retry-failed]

Each finger's dimensions and moduli are drawn evenly from what can be printed of thermoplastic
polyurethane (:data:`RANGES`), and drawn again until the finger is possible: a valid configuration
whose chambers are at least 1 mm wide, high and long inside. A longer table of the same seed
contains the shorter one.

================== ============ =======================================================
length             60–120 mm    as that of fingers for hand-sized objects
width              12–30 mm
depth              10–24 mm
base layer         1.5–5 mm
wall               0.8–2.5 mm   two to six lines of a 0.4 mm nozzle
bellows            4–12
gap                1–4 mm
channel            1.5–5 mm
base block         6–18 mm
tip                3–10 mm
μ                  1.5–6 MPa    printed polyurethane of about 70 A to 90 A
ν                  0.40–0.499
================== ============ =======================================================

The element is P2–P1, the size of the elements 3.5 walls and at most 6 mm: one quadratic element
across a wall, coarse, yet within a few percent of the limit.

A run ends by reaching 300 kPa, at a limit point (a physical end: no greater pressure can be
borne), or otherwise, which is a failure of the solver. The fingers are two campaigns, ``free`` and
``blocked`` in ``--out``, so a call resumes one that was killed. The folder also has
``outcomes.csv`` with a row for each finger, ``summary.md``, and ``failures/`` with the
configuration of each run that did not reach 300 kPa and, in its first line, the command that
repeats it.
"""

from __future__ import annotations

import argparse
import csv
import shlex
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.cli import doe_commands, progress
from dolfingrip.cli.console import console
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign.plan import Design, Plan
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import SchedulerGone
from dolfingrip.sections.tables import assignments

RANGES: dict[str, tuple[float, float]] = {
    "finger.length_mm": (60.0, 120.0),
    "finger.width_mm": (12.0, 30.0),
    "finger.depth_mm": (10.0, 24.0),
    "finger.base_layer_mm": (1.5, 5.0),
    "finger.wall_mm": (0.8, 2.5),
    "finger.bellows": (4, 12),
    "finger.gap_mm": (1.0, 4.0),
    "finger.channel_mm": (1.5, 5.0),
    "finger.base_block_mm": (6.0, 18.0),
    "finger.tip_mm": (3.0, 10.0),
    "material.mu_MPa": (1.5, 6.0),
    "material.nu": (0.40, 0.499),
}
"""Bounds of what is drawn, in the unit that the key's name ends in."""

OURS = (
    "solver.element=P2-P1",
    "solver.max_step_kPa=50",
    "solver.min_step_kPa=1",
)
"""Settings that differ from those of ``dolfingrip doe``: many of these fingers are too soft
for its long steps. One that ends at a limit point costs as much as several that do not, and
more the closer the approach."""

SIZE_KEY = "mesh.size_mm"
WALLS, LARGEST_MM = 3.5, 6.0
"""Element size in walls, and its bound."""

CLEAR_MM = 1.0
"""Smallest inner length, width and height of a chamber."""

RUNS = {"free": ("angle_deg", "bend"), "blocked": ("force_N", "force")}
"""Quantity and command of each campaign."""

REACHED, LIMIT = "reached", "limit point"
GOAL = 0.99
"""Required part of runs that reach the end or a limit point."""


def base(overrides: Sequence[str] = ()) -> Config:
    """Return the configuration that all fingers share."""
    return doe_commands.base(None, assignments([*OURS, *overrides]))


def draw(number: int, seed: int, shared: Config) -> list[Inputs]:
    """The first ``number`` possible fingers of a seed."""
    rng = np.random.default_rng(seed)
    found: list[Inputs] = []
    while len(found) < number:
        inputs: Inputs = {}
        for key, (low, high) in RANGES.items():
            if isinstance(low, int):
                inputs[key] = int(rng.integers(low, high, endpoint=True))
            else:
                inputs[key] = round(float(rng.uniform(low, high)), 3)
        inputs[SIZE_KEY] = round(min(WALLS * inputs["finger.wall_mm"], LARGEST_MM), 3)
        if possible(inputs, shared):
            found.append(inputs)
    return found


def possible(inputs: Inputs, shared: Config) -> bool:
    """Tell if there is such a finger, its chambers clear enough to be printed."""
    try:
        finger = configuration.from_dict(design_of(inputs, shared).config).finger
    except ConfigError:
        return False
    inside = (
        finger.bellows_mm - 2 * finger.wall_mm,
        finger.chamber_width_mm,
        finger.depth_mm - finger.base_layer_mm - 2 * finger.wall_mm - finger.channel_mm,
    )
    return min(inside) >= CLEAR_MM


def plan(run: str, points: Sequence[Inputs], shared: Config) -> Plan:
    """The campaign of one kind of run."""
    return Plan(shared, (*RANGES, SIZE_KEY), tuple(points), (RUNS[run][0],))


def design_of(inputs: Inputs, shared: Config, run: str = "free") -> Design:
    """One finger as a design of a campaign."""
    return plan(run, [inputs], shared).designs()[0]


def outcomes(out: Path, points: Sequence[Inputs], shared: Config) -> list[dict[str, Any]]:
    """A row for each finger: parameters, then how each run ended."""
    stored = {}
    for run in RUNS:
        stored[run] = campaign.read(out / run).by_key()
    rows = []
    for number, inputs in enumerate(points):
        row: dict[str, Any] = {"finger": number, **inputs}
        for run, (quantity, _) in RUNS.items():
            kept = stored[run][design_of(inputs, shared, run).key]
            end = {"done": REACHED, "failed": kept.failure_class}.get(kept.status, "missing")
            row |= {
                f"{run}_end": end,
                f"{run}_{quantity}": (kept.outputs or {}).get(quantity),
                f"{run}_failure": kept.failure,
                f"{run}_iterations": kept.iterations,
                f"{run}_wall_s": kept.wall_s,
            }
        rows.append(row)
    return rows


def write_table(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """``outcomes.csv``."""
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def write_failures(rows: Sequence[dict[str, Any]], shared: Config, folder: Path) -> list[Path]:
    """A configuration, with the command that runs it, for each run that stopped early."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.toml"):
        old.unlink()
    written = []
    for row in rows:
        inputs = {key: row[key] for key in (*RANGES, SIZE_KEY)}
        for run, (_, command) in RUNS.items():
            if row[f"{run}_end"] == REACHED:
                continue
            path = folder / f"{row['finger']:03d}_{run}.toml"
            settings = configuration.from_dict(design_of(inputs, shared, run).config)
            words = ["scripts/run", "dolfingrip", command, "--config", str(path)]
            head = f"# {shlex.join(words)}\n# {row[f'{run}_end']}: {row[f'{run}_failure']}\n\n"
            path.write_text(head + configuration.dumps(settings), encoding="utf-8")
            written.append(path)
    return written


def summary(rows: Sequence[dict[str, Any]], seed: int) -> str:
    """Number of runs by how they ended."""
    kinds = list(RUNS)
    ends = {run: Counter(row[f"{run}_end"] for row in rows) for run in kinds}
    every = sum((ends[run] for run in kinds), Counter())
    others = sorted(set(every) - {REACHED, LIMIT})
    lines = [
        f"{len(rows)} random fingers of seed {seed}, pressurised to 300 kPa.",
        "",
        "| end | free | blocked |",
        "|---|--:|--:|",
        *(f"| {end} | {ends['free'][end]} | {ends['blocked'][end]} |" for end in (REACHED, LIMIT)),
        *(f"| {end} | {ends['free'][end]} | {ends['blocked'][end]} |" for end in others),
        "",
    ]
    well, total = every[REACHED] + every[LIMIT], every.total()
    lines.append(
        f"{well} of {total} runs ({well / total:.1%}) reached the end or a limit point; "
        f"goal: {GOAL:.0%} or more."
    )
    return "\n".join(lines) + "\n"


def main() -> int:
    """Run what is missing, then write table, failures and summary."""
    parser = argparse.ArgumentParser(
        prog="scripts/robustness", description="Random fingers, free and blocked, to 300 kPa."
    )
    parser.add_argument("--number", type=int, default=200, metavar="N", help="default: 200")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="default: 0")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--out", type=Path, default=Path("out/robustness"), metavar="FOLDER")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    parser.add_argument(
        "--retry-failed", action="store_true", help="compute again what ended neither well nor at "
        "a limit point",
    )  # fmt: skip
    asked = parser.parse_args()
    for name in ("number", "workers"):
        if getattr(asked, name) < 1:
            parser.error(f"--{name} {getattr(asked, name)}: allowed: 1 or more")
    screen = console()
    try:
        shared = base(asked.overrides)
        points = draw(asked.number, asked.seed, shared)
        screen.print(f"robustness: {len(points)} fingers of seed {asked.seed}", soft_wrap=True)
        for run in RUNS:
            screen.print(f"robustness: {run}", soft_wrap=True)
            with progress.jobs(screen, "designs", progress.FEW) as show:
                campaign.run(
                    plan(run, points, shared), asked.out / run, Where(workers=asked.workers),
                    retry_failed=asked.retry_failed, spared=[LIMIT], progress=show,
                )  # fmt: skip
    except ConfigError as error:
        parser.error(str(error))
    except SchedulerGone as gone:
        screen.print(f"robustness: {gone}", soft_wrap=True)
        return 1
    rows = outcomes(asked.out, points, shared)
    write_table(rows, asked.out / "outcomes.csv")
    failures = write_failures(rows, shared, asked.out / "failures")
    said = summary(rows, asked.seed)
    (asked.out / "summary.md").write_text(said, encoding="utf-8")
    screen.print(said, markup=False)
    screen.print(f"wrote {asked.out} and {len(failures)} configurations of runs that stopped early")
    return 0


if __name__ == "__main__":
    sys.exit(main())
