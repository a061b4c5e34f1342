"""Pictures of a diagnosis: readings and simulation, residuals, probabilities, before and after."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from dolfingrip.report.theme import BLUE, GREEN, GREY, INK, ORANGE, PALE, figure_theme

LABELS = {
    "angle_deg": "Tip angle (°)",
    "chord_angle_deg": "Chord angle (°)",
    "force_N": "Force (N)",
    "tip_x_mm": "Tip displacement x (mm)",
    "tip_z_mm": "Tip displacement z (mm)",
}
FEWEST_SHOWN = 0.002
"""Probability below which a class has no bar."""
WIDEST = 40
"""Characters of a line that names a class."""
BANDS = 2.0
"""Half width of the noise band, in standard deviations."""
MARKS = {"loading": "o", "unloading": "s", "hold": "^"}


def draw(data: Mapping[str, Any], out: Path) -> list[Path]:
    """Draw ``overlay.png``, ``residuals.png``, ``probabilities.png`` and ``gain.png``.

    Args:
        data: ``readings``, a table with the columns channel, experiment, specimen, branch,
            pressure_kPa, displacement_mm, value, noise, configured, before, after; ``cause``, its
            name or ""; ``probabilities`` by class; ``gain``, rows of errors by what was left out.
        out: folder.
    """
    drawn = [_overlay(data, out / "overlay.png"), _residuals(data, out / "residuals.png"),
             _probabilities(data, out / "probabilities.png")]  # fmt: skip
    if data["gain"]:
        drawn.append(_gain(data, out / "gain.png"))
    return drawn


def _panels(readings: pd.DataFrame) -> list[tuple[str, str, pd.DataFrame]]:
    return [
        (str(experiment), str(channel), part)
        for (experiment, channel), part in readings.groupby(["experiment", "channel"], sort=False)
    ]


@contextmanager
def _figure(path: Path, rows: int, columns: int, size: tuple[float, float]) -> Iterator[Any]:
    with figure_theme():
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure.subplots(rows, columns, squeeze=False)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=150)


def _over(part: pd.DataFrame) -> tuple[str, str]:
    if part["pressure_kPa"].notna().all():
        return "pressure_kPa", "Pressure (kPa)"
    return "displacement_mm", "Travel (mm)"


def _overlay(data: Mapping[str, Any], path: Path) -> Path:
    panels = _panels(data["readings"])
    with _figure(path, 1, len(panels), (4.6 * len(panels), 3.8)) as axes:
        for ax, (experiment, channel, part) in zip(axes[0], panels, strict=True):
            over, label = _over(part)
            for branch, own in part.groupby("branch", sort=False):
                ax.plot(own[over], own["value"], MARKS.get(str(branch), "o"), color=INK, ms=3,
                        mfc="none", mew=0.7, label=f"measured, {branch}", zorder=2)  # fmt: skip
            _lines(ax, part, over, "configured", "as configured", GREY, ":")
            _lines(ax, part, over, "before", "nuisances fitted", BLUE, "--")
            if data["cause"]:
                _lines(ax, part, over, "after", f"with {data['cause']}", ORANGE, "-", band=True)
            ax.set(xlabel=label, ylabel=LABELS.get(channel, channel),
                   title=experiment.replace("_", " "))  # fmt: skip
            ax.legend(loc="best")
    return path


def _lines(
    ax: Axes, part: pd.DataFrame, over: str, column: str, label: str, colour: str, style: str,
    band: bool = False,
) -> None:  # fmt: skip
    """One line for each run; of the first alone the band, and the label."""
    for number, (_, run) in enumerate(part.groupby("run", sort=False)):
        ax.plot(run[over], run[column], style, color=colour, lw=1.2, zorder=3,
                label=label if number == 0 else None)  # fmt: skip
        if band and number == 0:
            low, high = (run[column] + way * BANDS * run["noise"] for way in (-1, 1))
            ax.fill_between(run[over], low, high, color=colour, alpha=0.2, lw=0)


def _residuals(data: Mapping[str, Any], path: Path) -> Path:
    panels = _panels(data["readings"])
    kinds = [("before", "nuisances fitted", BLUE)]
    if data["cause"]:
        kinds.append(("after", f"with {data['cause']}", ORANGE))
    with _figure(path, len(kinds), len(panels), (4.6 * len(panels), 2.8 * len(kinds))) as axes:
        for column, (experiment, channel, part) in enumerate(panels):
            over, label = _over(part)
            for row, (name, title, colour) in enumerate(kinds):
                ax = axes[row][column]
                rest = part.sort_values(over)
                ax.fill_between(rest[over], -BANDS * rest["noise"], BANDS * rest["noise"],
                                color=PALE, alpha=0.6, lw=0, label="noise (2 std)")  # fmt: skip
                for branch, own in part.groupby("branch", sort=False):
                    ax.plot(own[over], own[name] - own["value"], MARKS.get(str(branch), "o"),
                            color=colour, ms=3, mfc="none", mew=0.8, label=str(branch))  # fmt: skip
                ax.axhline(0, color=INK, lw=0.8)
                ax.set(
                    xlabel=label,
                    ylabel=f"Δ {LABELS.get(channel, channel)}",
                    title=f"{experiment.replace('_', ' ')}: simulated − measured, {title}",
                )
                ax.title.set_fontsize(8)
                ax.legend(loc="best")
    return path


def _probabilities(data: Mapping[str, Any], path: Path) -> Path:
    shown = {k: v for k, v in data["probabilities"].items()
             if v >= FEWEST_SHOWN or k in ("none", "unknown")}  # fmt: skip
    names = sorted(shown, key=lambda name: shown[name])
    texts = [fill(name, WIDEST) for name in names]
    lines = sum(1 + text.count("\n") for text in texts)
    with _figure(path, 1, 1, (6.4, 0.9 + 0.14 * lines + 0.2 * len(names))) as axes:
        ax = axes[0][0]
        colours = [GREY if name in ("none", "unknown") else GREEN for name in names]
        ax.barh(texts, [shown[n] for n in names],
                color=colours)  # fmt: skip
        for number, name in enumerate(names):
            ax.text(shown[name] + 0.01, number, f"{shown[name]:.2f}", va="center", fontsize=8)
        ax.set(xlabel="Probability that it takes part", xlim=(0, 1.1))
        ax.grid(axis="y", visible=False)
    return path


def _gain(data: Mapping[str, Any], path: Path) -> Path:
    table = pd.DataFrame(data["gain"])
    channels = list(dict.fromkeys(table["channel"]))
    bars = (("before", "as configured", PALE), ("nuisances", "nuisances refitted", BLUE),
            ("process", "process without cause", GREY),
            ("cause", "with the cause", ORANGE))  # fmt: skip
    with _figure(path, 1, len(channels), (4.8 * len(channels), 3.4)) as axes:
        for ax, channel in zip(axes[0], channels, strict=True):
            rows = table[table["channel"] == channel]
            place = np.arange(len(rows))
            for number, (name, label, colour) in enumerate(bars):
                ax.bar(place + 0.2 * (number - 1.5), rows[name], 0.19, color=colour, label=label)
            ends = np.array(rows["interval"].tolist())
            ax.vlines(place + 0.3, ends[:, 0], ends[:, 1], color=INK, lw=1.0)
            ax.set_yscale("log")
            ax.set_xticks(place, [f"{name}\nleft out" for name in rows["left_out"]])
            ax.set(ylabel=f"Error on left-out readings\n{LABELS.get(channel, channel)}")
            ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return path
