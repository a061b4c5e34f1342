"""Every reading of some small simulations, held to stored figures.

    scripts/run env PYTHONPATH=tests python -m tools.stored_values [--only CASE …] [--write]

A change of the code that should not change results is checked by it: each figure is compared with
``tests/tools/stored_values.csv``, relative to the largest of the case that has its unit. The
figures are this code's own: they show a change, not correctness. ``--write`` replaces them. The
cases have every effect of the catalogue.
It takes about three minutes of processor time.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Iterator
from pathlib import Path

from dolfingrip import config, experiments
from dolfingrip.experiments import Result
from dolfingrip.sections.tables import assignments

TABLE = Path(__file__).with_suffix(".csv")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TOLERANCE = 1e-9
"""Relative change of a figure that counts as none. Newton's method ends at a relative residual of
1e-8 and converges quadratically, so that its own error is smaller."""
DERIVATIVE_TOLERANCE = 3e-5
"""For derivatives, which are difference quotients of residuals: the order of sums changes from run
to run, and their rounding with it. Where bellows touch, runs of commit 14eda85 spread by 7e-6, and
one later run was 2e-5 off the stored figure."""
COARSE = ("mesh.edge_size_mm=7", "experiment.step_kPa=50", "experiment.max_pressure_kPa=100")
COUNTS = ("iterations", "load_steps")
"""Columns that must not grow; they may fall."""

CASES: dict[str, tuple[str, tuple[str, ...]]] = {
    "free": ("bending", COARSE),
    "blocked": ("blocked_force", COARSE),
    "history": (
        "cycle",
        (*COARSE, "experiment.cycles=2", "extensions.prony={}", "extensions.mullins={}",
         "extensions.permanent_set={}"),
    ),
    "instruments": (
        "blocked_force",
        (*COARSE, "experiment.unload=true", "extensions.force_gain={}",
         "extensions.angle_offset={}", "extensions.set_point_logged={}",
         "extensions.temperature_drift={}"),
    ),
    "clamp": ("blocked_force", (*COARSE, "extensions.clamp_compliance={}")),
    "plate": (
        "blocked_force",
        (*COARSE, "extensions.plate_friction={}", "extensions.plate_compliance={}",
         "extensions.bellows_friction={}"),
    ),
    "laws": (
        "bending",
        (*COARSE, "extensions.mooney_rivlin={}", "extensions.ogden={}",
         "extensions.print_anisotropy={}", "gravity.acceleration_m_s2=9.81"),
    ),
    "other laws": (
        "bending",
        (*COARSE, "extensions.bulk_modulus={}", "extensions.gent={}", "extensions.ogden_terms={}",
         "extensions.polynomial={}"),
    ),
    "set-up": (
        "blocked_force",
        (*COARSE, "experiment.unload=true", "extensions.base_layer_offset.offset_mm=0.1",
         "extensions.wall_offset.offset_mm=0.1", "extensions.gravity_pitch.pitch_deg=3",
         "extensions.plate_gap={}", "extensions.plate_tilt.offset_deg=2",
         "extensions.pressure_gain.gain=1.02", "extensions.pressure_offset.offset_kPa=2",
         "extensions.angle_definition={}", "extensions.angle_gain.gain=1.02",
         "extensions.force_offset.offset_N=0.02", "extensions.zero_drift.force_N_per_s=1e-4"),
    ),
    "numerical": (
        "bending",
        (*COARSE, "extensions.no_self_contact={}", "extensions.coarse_mesh={}",
         "extensions.locking={}"),
    ),
    "mixed": (
        "bending",
        (*COARSE, "mesh.edge_size_mm=4", "solver.element=P2-P1", "mesh.size_mm=4",
         "material.nu=0.49"),
    ),
    "volume": ("bending", (*COARSE, "experiment.control=volume", "material.mu_MPa=1.0")),
    "coupon": ("coupon", ("extensions.yeoh={}", "extensions.prony={}", "coupon.max_strain=0.5")),
    "push": ("push", COARSE),
    "membrane": (
        "bending",
        (*COARSE, "film.tape.face=back", "film.tape.Et_N_per_mm=2",
         "gravity.acceleration_m_s2=9.81"),
    ),
    "cast": ("bending", ()),
    "grasp": (
        "grasp",
        ("food.kind=potato-small", "gripper.alpha_deg=30", "gripper.preset=coarse",
         "experiment.max_pressure_kPa=150"),
    ),
}  # fmt: skip
"""Experiment and overrides by name."""


def simulated(name: str) -> Result:
    """The result of one case."""
    kind, overrides = CASES[name]
    path = EXAMPLES / "cast_block.toml" if name == "cast" else None
    gradients = ("material.mu_MPa", "finger.wall_mm") if name in ("free", "blocked") else None
    return experiments.run(
        kind, config.load(path, overrides=assignments(list(overrides))), gradients=gradients
    )


def figures(name: str) -> Iterator[tuple[str, int, str, float]]:
    """Case, row, column and value of every finite number of a case."""
    result = simulated(name)
    if result.failure is not None:
        raise SystemExit(f"{name}: {result.failure.sentence()}")
    for place, row in enumerate(result.rows):
        for column, value in row.items():
            if isinstance(value, int | float) and math.isfinite(value):
                yield name, place, column, float(value)
    for row in result.sensitivities:
        yield name, row["row"], f"d {row['column']} / d {row['parameter']}", row["derivative"]


def unit(column: str) -> str:
    """The unit at a column's end; a derivative is of a unit of its own."""
    return column if column.startswith("d ") else column.rpartition("_")[2]


def changes(found: list[tuple[str, int, str, float]]) -> Iterator[str]:
    """A line for each figure that is not as stored."""
    with TABLE.open(encoding="utf-8", newline="") as stream:
        stored = {tuple(row[:3]): float(row[3]) for row in list(csv.reader(stream))[1:]}
    scales: dict[tuple[str, str], float] = {}
    for (case, _, column), value in stored.items():
        scales[case, unit(column)] = max(scales.get((case, unit(column)), 1e-9), abs(value))
    ran = {case for case, *_ in found}
    missing = {key for key in stored if key[0] in ran}
    for case, row, column, value in found:
        missing.discard((case, str(row), column))
        then = stored.get((case, str(row), column))
        if then is None:
            yield f"{case}, row {row}: {column} is new"
        elif column in COUNTS:
            if value > then:
                yield f"{case}, row {row}: {column} {then:g} → {value:g}"
        else:
            change = abs(value - then) / scales[case, unit(column)]
            if change > (DERIVATIVE_TOLERANCE if column.startswith("d ") else TOLERANCE):
                yield f"{case}, row {row}: {column} {then!r} → {value!r} ({change:.1e})"
    yield from (f"{case}, row {row}: {column} is missing" for case, row, column in sorted(missing))


def main() -> None:
    """Run the cases; compare them with the table, or write it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--write", action="store_true")
    asked = parser.parse_args()
    found = []
    for name in asked.only:
        found += list(figures(name))
        print(f"{name}: {len(found)} figures so far", flush=True)
    if asked.write:
        with TABLE.open("w", encoding="utf-8", newline="") as stream:
            table = csv.writer(stream, lineterminator="\n")
            table.writerow(("case", "row", "column", "value"))
            table.writerows((*row, repr(value)) for *row, value in found)
        return
    lines = list(changes(found))
    print("\n".join(lines) if lines else f"{len(found)} figures, all as stored")
    if lines:
        sys.exit(1)


if __name__ == "__main__":
    main()
