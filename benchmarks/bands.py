"""Bands of one run against random runs: a finger whose uncertain numbers are drawn.

    scripts/run python -m benchmarks.bands

writes ``benchmarks/bands.csv``. Runs are kept in ``--out``, so that a second call goes on. It takes
about five minutes of one core. Seeds are those of the runs' numbers, 0, 1, ….
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip.channels import of_band
from dolfingrip.config import changed, load
from dolfingrip.experiments.derivatives.bands import Bands
from dolfingrip.experiments.index import find
from dolfingrip.experiments.loop import run
from dolfingrip.files import table, whole
from dolfingrip.parameter import find as parameters
from dolfingrip.parameter.nuisances import STIFFNESSES, changes
from dolfingrip.sections.tables import assignments

TABLE: Final = Path(__file__).with_suffix(".csv")
_SHORT: Final = (
    "finger.bellows=3 finger.length_mm=45 plate.contact_length_mm=10 mesh.edge_size_mm=7 "
    "experiment.max_pressure_kPa=100 experiment.step_kPa=50"
)
ROWS: Final = (
    ("bending", 120, _SHORT, ("angle_deg", "tip_x_mm", "tip_z_mm")),
    ("blocked_force", 60, f"{_SHORT} plate.gap_mm=1", ("force_N",)),
)
"""Experiment, random runs, settings, readings; no plate can be nearer than at 0 mm."""


def drawn(bands: Bands, seed: int) -> dict[str, float]:
    """Draw values of the parameters: factors of moduli log-normal, others normal.

    Args:
        bands: of the run.
        seed: of the numbers.
    """
    random = np.random.default_rng(seed)
    moved: dict[str, float] = {}
    for key, std in bands.spreads.items():
        if key not in bands.changes:
            continue
        zeta = float(random.standard_normal())
        amount = float(np.expm1(std * zeta)) if key in STIFFNESSES else std * zeta
        for parameter, change in changes(bands.config, key, amount).items():
            moved[parameter] = moved.get(parameter, 0.0) + change
    known = {each.key: each.value(bands.config) for each in parameters(bands.config, list(moved))}
    return {key: known[key] + change for key, change in moved.items()}


def rows(folder: Path) -> list[dict[str, object]]:
    """Make the table.

    Args:
        folder: in which answers are kept.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "bands.json"
    known: dict[str, Any] = json.loads(file.read_text("utf-8")) if file.exists() else {}
    found: list[dict[str, object]] = []
    for name, number, settings, columns in ROWS:
        experiment = find(name)
        config = experiment.settings(load(None, assignments(settings.split())))
        one = run(name, config, bands={})
        bands = Bands.of(experiment, config, {})
        drawn_rows = []
        for seed in range(number):
            key = f"{name} {settings} {seed}"
            if key not in known:
                values = drawn(bands, seed)
                answer = run(name, changed(bands.config, values))
                ended = answer.failure is not None
                known[key] = None if ended else {c: float(answer.column(c)[-1]) for c in columns}
                whole.write(file, json.dumps(known))
                print(key, known[key], flush=True)
            drawn_rows.append(known[key])
        reached = [each for each in drawn_rows if each is not None]
        for column in columns:
            values = np.array([each[column] for each in reached])
            low, high = (float(one.column(end)[-1]) for end in of_band(column))
            ends = np.quantile(values, (0.025, 0.975))
            found.append(
                {
                    "experiment": name, "reading": column,
                    "value": f"{one.column(column)[-1]:.4g}",
                    "low": f"{low:.4g}", "high": f"{high:.4g}",
                    "low_of_runs": f"{ends[0]:.4g}", "high_of_runs": f"{ends[1]:.4g}",
                    "width_by_runs": f"{(high - low) / (ends[1] - ends[0]):.2f}",
                    "inside": int(((low <= values) & (values <= high)).sum()),
                    "runs": len(values),
                }
            )  # fmt: skip
        table.write(TABLE, found)
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/bands"))
    for row in rows(parser.parse_args(arguments).out):
        print(*row.values(), sep="\t")


if __name__ == "__main__":
    main()
