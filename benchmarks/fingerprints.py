"""The influence of each effect on angle and force: a page of small plots and a table.

    scripts/run python -m benchmarks.fingerprints [--only prony,mullins] [--out FOLDER] [--publish]

Each effect at its default values against the base model, loading and unloading, effects with a
clock at two rates. A finger that has been computed is not computed again, so that the script can be
stopped and started; finished ones are drawn. ``--publish`` makes ``benchmarks/fingerprints.csv``
and ``docs/fingerprints.png`` of it. The whole takes about 16 minutes of CPU time.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from shutil import copyfile
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from benchmarks.parts import UNGRADED_MM
from dolfingrip import config
from dolfingrip.charts import theme
from dolfingrip.experiments import run
from dolfingrip.extensions.index import NAMES
from dolfingrip.files.table import write
from dolfingrip.sections.tables import assignments

OVERRIDES = (
    "experiment.step_kPa=12.5",
    "experiment.unload=true",
    f"mesh.edge_size_mm={UNGRADED_MM}",
)
"""The reference finger to 250 kPa and back, read often enough to see where bellows touch; on an
ungraded mesh, since only changes are shown."""

RATES = {"fast": 100.0, "slow": 2.0}
"""kPa/s."""
CLOCKS = ("prony", "temperature_drift", "set_point_logged", "zero_drift", "sensor_lag")
BASE = "base"
COLUMNS = {"bending": "angle_deg", "blocked_force": "force_N"}
LABELS = {"bending": "Δ angle (°)", "blocked_force": "Δ force (N)"}
COLOURS = {"fast": theme.BLUE, "slow": theme.ORANGE}
ACROSS = 3
"""Effects side by side."""
ROUNDING = 1e-4
"""Angles (°) and forces (N) below which a change is within Newton's tolerance."""
HERE = Path(__file__).resolve().parent
TABLE, PAGE = HERE / "fingerprints.csv", HERE.parent / "docs" / "fingerprints.png"


def settings(name: str, rate: str) -> list[str]:
    """Overrides of one run."""
    on = [] if name == BASE else [f"extensions.{name}={{}}"]
    return [*OVERRIDES, f"experiment.rate_kPa_per_s={RATES[rate]}", *on]


def computed(name: str, rate: str, folder: Path) -> dict[str, Any]:
    """Curves of an effect at one rate, from the folder where they are there."""
    file = folder / f"{name}-{rate}.json"
    asked = config.load(None, assignments(settings(name, rate))).model_dump(
        mode="json", exclude_none=True
    )
    if file.exists():
        found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        if found["config"] == asked:
            return found
    found = {"config": asked}
    for kind in COLUMNS:
        print(f"{name}, {rate}: {kind}", flush=True)
        found[kind] = curve(kind, settings(name, rate))
    folder.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(found), encoding="utf-8")
    return found


def curve(kind: str, overrides: Sequence[str]) -> dict[str, Any]:
    """Pressure, branch and reading of one run."""
    result = run(kind, config.load(None, assignments(overrides)))
    return {
        "pressure_kPa": result.column("pressure_kPa").tolist(),
        "reading": result.column(COLUMNS[kind]).tolist(),
        "branch": [row["branch"] for row in result.rows],
        "failure": result.failure and result.failure.sentence(),
    }


def change(found: dict[str, Any], base: dict[str, Any], kind: str) -> np.ndarray:
    """Pressure and difference from the base model (n, 2), as far as both went."""
    count = min(len(found[kind]["reading"]), len(base[kind]["reading"]))
    difference = np.subtract(found[kind]["reading"][:count], base[kind]["reading"][:count])
    return np.stack([found[kind]["pressure_kPa"][:count], difference], axis=1)


def rates(name: str) -> list[str]:
    """The rates that an effect is run at."""
    return list(RATES) if name in CLOCKS else ["fast"]


def draw(names: Sequence[str], folder: Path) -> Path:
    """Draw the page of all that is there."""
    base = computed(BASE, "fast", folder)
    down = -(-len(names) // ACROSS)
    with theme.figure_theme():
        figure, panels = plt.subplots(
            down, 2 * ACROSS, figsize=(2.1 * 2 * ACROSS, 1.75 * down), layout="constrained",
            squeeze=False,
        )  # fmt: skip
        for axes in panels.flat[2 * len(names) :]:
            axes.set_axis_off()
        for place, name in enumerate(names):
            pair = panels.flat[2 * place : 2 * place + 2]
            for axes, kind in zip(pair, COLUMNS, strict=True):
                lines = {rate: computed(name, rate, folder) for rate in rates(name)}
                _panel(axes, {rate: change(line, base, kind) for rate, line in lines.items()})
                axes.set_title(f"{name}: {LABELS[kind]}", fontsize=8)
                axes.tick_params(labelsize=7.5)
                if place >= len(names) - ACROSS:
                    axes.set_xlabel("pressure (kPa)", fontsize=8)
        handles = [
            plt.Line2D([], [], color=COLOURS[rate], ls=style, label=f"{words}{branch}")
            for rate, words in (("fast", f"{RATES['fast']:g} kPa/s or any rate, "),
                                ("slow", f"{RATES['slow']:g} kPa/s, "))
            for style, branch in (("-", "loading"), ("--", "unloading"))
        ]  # fmt: skip
        figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=8)
        path = folder / "fingerprints.png"
        figure.savefig(path, dpi=150)
        plt.close(figure)
    return path


def _panel(axes: Axes, lines: Mapping[str, np.ndarray]) -> None:
    """Changes from the base model (pressure, change), by rate."""
    for rate, points in lines.items():
        turn = int(np.argmax(points[:, 0]))
        axes.plot(*points[: turn + 1].T, "-", color=COLOURS[rate], lw=1.3)
        axes.plot(*points[turn:].T, "--", color=COLOURS[rate], lw=1.3)
    axes.axhline(0, color=theme.GREY, lw=0.8, zorder=1)
    if max(np.abs(points[:, 1]).max() for points in lines.values()) < ROUNDING:
        axes.set_ylim(-1, 1)
        axes.set_yticks([0])
        axes.text(0.5, 0.56, "none", ha="center", fontsize=8, transform=axes.transAxes)


def table(names: Sequence[str], folder: Path) -> list[dict[str, Any]]:
    """A row for the base model and for each effect and rate.

    Angle and force at the highest pressure, and their changes from the base model: half-way up,
    there, half-way back and vented. Places that a run did not come to are empty.
    """
    base = computed(BASE, "fast", folder)
    top = int(np.argmax(base["bending"]["pressure_kPa"]))
    places = {"half_up": top // 2, "top": top, "half_back": 2 * top - top // 2, "vented": 2 * top}
    made: list[dict[str, Any]] = []
    for name in (BASE, *names):
        for rate in rates(name):
            found = computed(name, rate, folder)
            row: dict[str, Any] = {"effect": name}
            row["rate_kPa_per_s"] = f"{RATES[rate]:g}" if name in CLOCKS else "any"
            for kind, column in COLUMNS.items():
                quantity, unit = column.split("_")
                reading, changes = found[kind]["reading"], change(found, base, kind)[:, 1]
                row[column] = f"{reading[top]:.5g}" if top < len(reading) else ""
                for place, index in places.items():
                    there = index < len(changes)
                    # + 0 turns what is rounded to −0 into 0
                    value = f"{round(changes[index], 4) + 0:.4f}" if there else ""
                    row[f"{quantity}_change_{place}_{unit}"] = value
            made.append(row)
    return made


def main() -> None:
    """Compute what is not there, draw all that is."""
    parser = argparse.ArgumentParser(description="Fingerprints of the model extensions.")
    parser.add_argument("--only", help="effects, joined by commas; default: all")
    parser.add_argument("--out", type=Path, default=Path("out/fingerprints"))
    parser.add_argument("--publish", action="store_true", help="to benchmarks/ and docs/, too")
    asked = parser.parse_args()
    names = asked.only.split(",") if asked.only else list(NAMES)
    unknown = [name for name in names if name not in NAMES]
    if unknown:
        parser.error(f"--only {unknown[0]}: allowed: {', '.join(NAMES)}")
    computed(BASE, "fast", asked.out)
    for name in names:
        for rate in rates(name):
            computed(name, rate, asked.out)
    found = table(names, asked.out)
    write(asked.out / "fingerprints.csv", found)
    for row in found:
        print(*row.values(), sep="\t")
    page = draw(names, asked.out)
    print(page)
    if asked.publish:
        copyfile(asked.out / "fingerprints.csv", TABLE)
        copyfile(page, PAGE)


if __name__ == "__main__":
    main()
