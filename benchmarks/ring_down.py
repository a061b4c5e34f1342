"""How a finger's ring-down converges with the step in time: ``python -m benchmarks.ring_down``.

The default finger, on a coarse mesh, is pressurised to 100 kPa in 50 ms and swings from then on
without damping (``hht_alpha`` = 0), in equal steps. Each row has a step and

* the root mean square by which the angle differs from that with half the step, as it is, and
  smoothed over 25 ms, which leaves the first mode alone;
* the order that this difference and that of the row before tell, of both;
* the largest change of the energy after the rise, by the largest kinetic energy, and its order.

Newmark's scheme lets a mode lag by (ω Δt)²/12 of its phase. So higher modes are out of step long
before the first one is: their part of the difference does not fall until Δt resolves them.
"""

from __future__ import annotations

import csv
import itertools
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from dolfingrip import config
from dolfingrip.experiments import run

FINGER = {"mesh.size_mm": 12.0, "mesh.edge_size_mm": 12.0, "contact.self_contact": False}
STEPS_MS = (5.0, 2.5, 1.25, 0.625, 0.3125)
PRESSURE_KPA, RISE_S, END_S, EVERY_S = 100.0, 0.05, 0.2, 0.005
SMOOTHED = 5
"""Readings in 25 ms."""

ERRORS = {
    "difference_deg": "order", "first_mode_deg": "first_mode_order",
    "energy_change": "energy_order",
}  # fmt: skip
"""Columns of what tends to 0 with the step, and of the orders that it does so by."""

COLUMNS = ("step_ms", *(name for pair in ERRORS.items() for name in pair))


def swung(
    finger: Mapping[str, object], step_s: float, loading: Mapping[str, Sequence[float]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angle (°), energy and kinetic energy (mJ) of a finger from the highest pressure on.

    Args:
        finger: changes of the default configuration.
        step_s: length of all steps.
        loading: ``time_s`` and ``pressure_kPa`` of the readings, the last pressures the highest.
    """
    asked = config.load(
        None,
        {
            **finger, **{f"protocol.{key}": list(values) for key, values in loading.items()},
            "experiment.dynamic": True, "solver.hht_alpha": 0.0, "solver.max_step_s": step_s,
            "solver.time_error_mm": 10.0,
        },
    )  # fmt: skip
    result = run("bending", asked)
    assert result.failure is None, result.failure.sentence()
    taken = sum(int(row["load_steps"]) for row in result.rows)
    assert taken == 1 + round(loading["time_s"][-1] / step_s), "steps are not equal"
    held = result.column("pressure_kPa") == max(loading["pressure_kPa"])
    names = ("angle_deg", "energy_mJ", "kinetic_energy_mJ")
    angle, energy, kinetic = (result.column(name)[held] for name in names)
    return angle, energy, kinetic


def rows(
    finger: Mapping[str, object], steps_s: Sequence[float], loading: Mapping[str, Sequence[float]]
) -> list[dict[str, float]]:
    """Rows of the table, one for each step but the last.

    Args:
        finger: changes of the default configuration.
        steps_s: lengths of steps; each is half of the one before.
        loading: as that of :func:`swung`.
    """
    table: list[dict[str, float]] = []
    motions = (swung(finger, step_s, loading) for step_s in steps_s)
    for step_s, (here, finer) in zip(steps_s, itertools.pairwise(motions), strict=False):
        off = here[0] - finer[0]
        smooth = np.convolve(off, np.full(SMOOTHED, 1 / SMOOTHED), mode="valid")
        row = {
            "step_ms": 1e3 * step_s,
            "difference_deg": float(np.sqrt(np.mean(off**2))),
            "first_mode_deg": float(np.sqrt(np.mean(smooth**2))),
            "energy_change": float(np.abs(here[1] - here[1][0]).max() / here[2].max()),
        }
        for name, order in ERRORS.items():
            row[order] = float(np.log2(table[-1][name] / row[name])) if table else np.nan
        table.append(row)
        print(row, flush=True)
    return table


def main() -> None:
    """Write the table to the file that is named, or to the committed one."""
    file = Path(sys.argv[1] if len(sys.argv) > 1 else "benchmarks/ring_down.csv")
    times_s = [0.0, *np.arange(RISE_S, END_S + EVERY_S / 2, EVERY_S).tolist()]
    pressures = [0.0, *[PRESSURE_KPA] * (len(times_s) - 1)]
    loading = {"time_s": times_s, "pressure_kPa": pressures}
    steps_s = [step / 1e3 for step in STEPS_MS]
    with file.open("w", encoding="utf-8", newline="") as stream:
        table = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        table.writeheader()
        for row in rows(FINGER, steps_s, loading):
            shown = {name: f"{x:.3g}" if np.isfinite(x) else "" for name, x in row.items()}
            table.writerow(shown)


if __name__ == "__main__":
    main()
