"""Measured coupons and the laws fitted to them, in three modes of tension."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from dolfingrip.experiments.material_fit.coupons import MODES, Series, farthest
from dolfingrip.experiments.material_fit.fit import Fit
from dolfingrip.experiments.material_fit.homogeneous import Mode
from dolfingrip.report.theme import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, figure_theme, save

SIZE_IN = (9.6, 3.8)
BEYOND = 3.0
"""Curves are cut off at so many times the largest stress that is measured or fitted best."""

_STYLES = [(colour, dash) for dash in ("--", ":") for colour in (ORANGE, GREEN, PURPLE, GREY)]


def plot(data: Sequence[Series], fits: Sequence[Fit], best: Fit, file: Path) -> Path:
    """Draw nominal stress against stretch: readings, all laws, the best with its 90 % interval.

    Args:
        data: readings of the coupons.
        fits: the fitted laws, the best one among them.
        best: the law that is drawn with its interval.
        file: PNG to write.
    """
    stretch = np.linspace(1.0, farthest(data), 120)
    with figure_theme():
        figure = Figure(figsize=SIZE_IN, layout="constrained")
        FigureCanvasAgg(figure)
        panels = figure.subplots(1, len(MODES))
        for axes, mode in zip(panels, MODES, strict=True):
            _panel(axes, mode, stretch, data, fits, best)
        panels[0].set_ylabel("Nominal stress (MPa)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5)
        save(figure, file)
    return file


def _panel(
    axes: Axes,
    mode: Mode,
    stretch: np.ndarray,
    data: Sequence[Series],
    fits: Sequence[Fit],
    best: Fit,
) -> None:
    measured = [series for series in data if series.mode == mode]
    middle, half = best.band(mode, stretch)
    styles = iter(_STYLES)
    for each in fits:
        if each is not best:
            colour, dash = next(styles)
            axes.plot(stretch, each.band(mode, stretch)[0], dash, color=colour, lw=1.2,
                      label=each.law.title)  # fmt: skip
    axes.fill_between(stretch, middle - half, middle + half, color=BLUE, alpha=0.2, lw=0,
                      label="90 % interval")  # fmt: skip
    axes.plot(stretch, middle, color=BLUE, lw=2.0, label=best.law.title)
    for i, series in enumerate(measured):
        axes.plot(series.stretch, series.stress_MPa, ".", color=INK, ms=3, zorder=4,
                  label="measured" if i == 0 else None)  # fmt: skip
    shown = [middle.max(), *(series.stress_MPa.max() for series in measured)]
    top = max(shown) if measured else BEYOND * max(float(middle.max()), 0.0)
    axes.set(
        title=f"{mode}, {'measured' if measured else 'predicted'}",
        xlabel="Stretch (–)",
        xlim=(1.0, stretch[-1]),
        ylim=(0.0, 1.08 * float(top) or 1.0),
    )
