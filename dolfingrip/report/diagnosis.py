"""Pictures of a diagnosis: readings and simulation, residuals, probabilities, before and after."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from textwrap import fill
from typing import Any, Final

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from dolfingrip.channels import CHANNELS, DISPLACEMENT, PRESSURE
from dolfingrip.report.theme import BLUE, GREEN, GREY, INK, ORANGE, PALE, figure_theme, save, tint


@dataclass(frozen=True, slots=True)
class DiagnosisPictures:
    """The contents of a diagnosis' pictures.

    Attributes:
        least_probability: probability below which a class has no bar.
        name_width: characters of a line that names a class.
        band_std: half width of the noise band, in standard deviations.
        same: part of the range of readings within which two ways are one line.
        across: panels side by side.
        most_specimens: specimens up to which each has panels of its own.
    """

    least_probability: float = 0.002
    name_width: int = 40
    band_std: float = 2.0
    same: float = 0.01
    across: int = 3
    most_specimens: int = 4


PICTURES: Final = DiagnosisPictures()


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
    """Title, channel and rows of each panel: a reading of an experiment, and of a specimen."""
    found = []
    for (experiment, channel), part in readings.groupby(["experiment", "channel"], sort=False):
        title = str(experiment).replace("_", " ")
        specimens = list(dict.fromkeys(part["specimen"]))
        if 1 < len(specimens) <= PICTURES.most_specimens and experiment != "coupon":
            for name in specimens:
                own = part[part["specimen"] == name]
                found.append((f"{title}, {name}", str(channel), own))
        else:
            found.append((title, str(channel), part))
    return found


def _grid(axes: Any, count: int) -> list[Axes]:
    """The first ``count`` axes row by row; the rest are taken off."""
    every: list[Axes] = list(axes.flat)
    for ax in every[count:]:
        ax.set_axis_off()
    return every[:count]


def _shape(count: int) -> tuple[int, int]:
    """Rows and columns of so many panels."""
    across = min(count, PICTURES.across)
    return -(-count // across), across


@contextmanager
def _figure(path: Path, rows: int, columns: int, size: tuple[float, float]) -> Iterator[Any]:
    with figure_theme():
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure.subplots(rows, columns, squeeze=False)
        save(figure, path, dpi=150)


def _over(part: pd.DataFrame) -> tuple[str, str]:
    control = PRESSURE if part[PRESSURE.name].notna().all() else DISPLACEMENT
    return control.name, control.label


def _overlay(data: Mapping[str, Any], path: Path) -> Path:
    panels = _panels(data["readings"])
    rows, across = _shape(len(panels))
    with _figure(path, rows, across, (4.6 * across, 3.6 * rows)) as axes:
        for ax, (title, channel, part) in zip(_grid(axes, len(panels)), panels, strict=True):
            over, label = _over(part)
            for branch, own in part.groupby("branch", sort=False):
                ax.plot(own[over], own["value"], MARKS.get(str(branch), "o"), color=INK, ms=3,
                        mfc="none", mew=0.7, label=f"measured, {branch}", zorder=2)  # fmt: skip
            draw_lines(ax, part, over, "configured", "as configured", GREY, ":")
            draw_lines(ax, part, over, "before", "nuisances fitted", BLUE, "--")
            if data["cause"]:
                draw_lines(ax, part, over, "after", _with(data["cause"]), ORANGE, "-", band=True)
            ax.set(xlabel=label, ylabel=CHANNELS[channel].label, title=title)
            ax.legend(loc="best", fontsize=7)
    return path


def draw_lines(
    ax: Axes, part: pd.DataFrame, over: str, column: str, label: str, colour: str, style: str,
    band: bool = False,
) -> None:  # fmt: skip
    """Draw one line for each run; of the first alone the band, and the label.

    A curve is drawn once: that of an elastic body there and back, and that of specimens that are
    simulated alike. Dashes that lie on one another look like a solid line.
    """
    drawn: list[pd.DataFrame] = []
    for number, (_, run) in enumerate(part.groupby("run", sort=False)):
        shown = first_way(run, over, column)
        if not any(_along(shown, other, over, column) for other in drawn):
            drawn.append(shown)
            ax.plot(shown[over], shown[column], style, color=colour, lw=1.2, zorder=3,
                    label=label if number == 0 else None)  # fmt: skip
        if band and number == 0:
            for way in ways(run[over].to_numpy(dtype=float)):
                own = run.iloc[way]
                low, high = (
                    own[column] + side * PICTURES.band_std * own["noise"] for side in (-1, 1)
                )
                # not translucent: where the bands of two ways overlap they would be darker
                ax.fill_between(own[over], low, high, color=tint(colour), lw=0, zorder=1)


def first_way(run: pd.DataFrame, over: str, column: str) -> pd.DataFrame:
    """The first way of a run alone, where all others go along it; measured loads scatter."""
    first = run.iloc[ways(run[over].to_numpy(dtype=float))[0]].sort_values(over)
    return first if _along(run, first, over, column) else run


def _along(run: pd.DataFrame, other: pd.DataFrame, over: str, column: str) -> bool:
    """Whether a run goes along another, whose load only grows; its ends may lie a little beyond."""
    if not other[over].is_monotonic_increasing:
        return False
    shared = run[run[over].between(other[over].iloc[0], other[over].iloc[-1])]
    if len(shared) < max(2, len(run) - 2):
        return False
    along = np.interp(shared[over], other[over], other[column])
    apart = float(np.abs(shared[column] - along).max())
    return apart < PICTURES.same * float(run[column].max() - run[column].min())


def _with(cause: str) -> str:
    """What a model with a cause, or with a pair of causes, is called."""
    return f"with {cause.replace(' with ', ' and ')}"


def ways(load: np.ndarray) -> list[slice]:
    """The parts of a run along which the load only grows, or only falls; turns belong to both."""
    steps = pd.Series(np.sign(np.diff(load))).replace(0, np.nan).ffill().bfill().fillna(1)
    turns = np.flatnonzero(np.diff(steps.to_numpy())) + 1  # a wait belongs to the way before it
    ends = [0, *turns, len(load) - 1]
    return [slice(first, last + 1) for first, last in pairwise(ends)]


def _residuals(data: Mapping[str, Any], path: Path) -> Path:
    """For each reading the residual with nuisances fitted, and below it that with the cause."""
    panels = _panels(data["readings"])
    kinds = [("before", "nuisances fitted", BLUE)]
    if data["cause"]:
        kinds.append(("after", _with(data["cause"]), ORANGE))
    rows, across = _shape(len(panels))
    size = (4.6 * across, 2.6 * rows * len(kinds))
    with _figure(path, rows * len(kinds), across, size) as axes:
        for number, (title, channel, part) in enumerate(panels):
            row, column = divmod(number, across)
            pair = [axes[row * len(kinds) + kind][column] for kind in range(len(kinds))]
            for ax, (name, what, colour) in zip(pair, kinds, strict=True):
                _residual(ax, part, name, colour)
                ax.set_ylabel(f"Δ {CHANNELS[channel].label}", fontsize=8)
                ax.set_title(f"{title}, {what}", fontsize=8)
            low = min(ax.get_ylim()[0] for ax in pair)
            high = max(ax.get_ylim()[1] for ax in pair)
            for ax in pair:
                ax.set_ylim(low, high)
        for number in range(len(panels), rows * across):
            row, column = divmod(number, across)
            for kind in range(len(kinds)):
                axes[row * len(kinds) + kind][column].set_axis_off()
        axes[0][0].figure.suptitle("Simulated − measured", fontsize=9)
    return path


def _residual(ax: Axes, part: pd.DataFrame, name: str, colour: str) -> None:
    over, label = _over(part)
    rest = part.sort_values(over)
    band = PICTURES.band_std * rest["noise"]
    ax.fill_between(rest[over], -band, band,
                    color=PALE, alpha=0.6, lw=0, label="noise (2 std)")  # fmt: skip
    for branch, own in part.groupby("branch", sort=False):
        ax.plot(own[over], own[name] - own["value"], MARKS.get(str(branch), "o"),
                color=colour, ms=3, mfc="none", mew=0.8, label=str(branch))  # fmt: skip
    ax.axhline(0, color=INK, lw=0.8)
    ax.set(xlabel=label)
    ax.legend(loc="best", fontsize=7)


def _probabilities(data: Mapping[str, Any], path: Path) -> Path:
    shown = {k: v for k, v in data["probabilities"].items()
             if v >= PICTURES.least_probability or k in ("none", "unknown")}  # fmt: skip
    names = sorted(shown, key=lambda name: shown[name])
    texts = [fill(name, PICTURES.name_width) for name in names]
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
    down, across = _shape(len(channels))
    with _figure(path, down, across, (4.8 * across, 3.4 * down)) as axes:
        for ax, channel in zip(_grid(axes, len(channels)), channels, strict=True):
            rows = table[table["channel"] == channel]
            place = np.arange(len(rows))
            for number, (name, label, colour) in enumerate(bars):
                ax.bar(place + 0.2 * (number - 1.5), rows[name], 0.19, color=colour, label=label)
            ax.vlines(place + 0.3, rows["cause_low"], rows["cause_high"], color=INK, lw=1.0)
            ax.set_yscale("log")
            ax.set_xticks(place, [f"{name}\nleft out" for name in rows["left_out"]])
            ax.set(ylabel=f"Error on left-out readings\n{CHANNELS[channel].label}")
            ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return path
