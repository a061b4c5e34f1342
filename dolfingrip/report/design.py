"""Pictures of the design loop: learning curve, fit, Pareto front, scatter of the optimiser."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from dolfingrip.channels import ANGLE, FORCE
from dolfingrip.report.theme import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, figure_theme, save
from dolfingrip.sections.units import unit

Numbers = npt.NDArray[np.float64]

LABELS = {
    "morph.xi1": "ξ₁",
    "morph.xi2": "ξ₂",
    "cog_offset_mm": "COG offset (mm)",
    FORCE.name: FORCE.called("Blocked force").label,
    ANGLE.name: ANGLE.label,
}
"""Axis labels of some quantities; the others are labelled by their names, which carry units."""


def plot_learning_curve(
    epoch: npt.NDArray[np.int_], training: Numbers, test: Numbers, path: Path, *, goal: float
) -> None:
    """Plot the mean squared errors of the normalised outputs against epochs, shapes (samples,)."""
    with _figure(path, 1) as (axes,):
        axes.semilogy(epoch, training, color=BLUE, label=f"training, last {training[-1]:.1e}")
        axes.semilogy(epoch, test, color=ORANGE, ls="--", label=f"test, last {test[-1]:.1e}")
        axes.axhline(goal, color=GREY, lw=1.0, ls=":", label=f"goal, {goal:g}")
        axes.set(xlabel="Epoch", ylabel="Mean squared error (normalised outputs)")
        axes.set_xlim(0, epoch[-1])
        axes.legend()


def plot_fit(
    names: Sequence[str],
    computed: Numbers,
    predicted: Numbers,
    test: npt.NDArray[np.bool_],
    path: Path,
) -> None:
    """Plot predicted against computed outputs, one panel for each output.

    Args:
        names: names of the outputs.
        computed, predicted: shape (designs, outputs).
        test: shape (designs,), whether a design was held out of the training.
    """
    with _figure(path, len(names)) as panels:
        for column, (name, axes) in enumerate(zip(names, panels, strict=True)):
            x, y = computed[:, column], predicted[:, column]
            both = [min(x.min(), y.min()), max(x.max(), y.max())]
            axes.plot(both, both, color=GREY, lw=1.0, zorder=1)
            rms = np.sqrt(np.mean((y - x)[test] ** 2))
            axes.plot(x[~test], y[~test], "o", color=BLUE, ms=3, label="training")
            label = f"test, RMS error {rms:.2g} {unit(name)}".strip()
            axes.plot(x[test], y[test], "D", color=ORANGE, ms=4, mfc="none", label=label)
            text = LABELS.get(name, name)
            axes.set(xlabel=f"{text}, finite elements", ylabel=f"{text}, surrogate")
            axes.set_aspect("equal", adjustable="datalim")
            axes.legend(loc="upper left")


@dataclass(frozen=True)
class Points:
    """Points in the plane of the objectives.

    Attributes:
        cog_mm, force_N: shape (points,).
    """

    cog_mm: Numbers
    force_N: Numbers


@dataclass(frozen=True)
class FrontPicture:
    """The contents of a Pareto front's picture; empty parts are left out.

    Attributes:
        front: Pareto front of the surrogate.
        cloud: the designs of experiments.
        failed: number of failed designs, for the legend.
        chosen: the chosen design for each COG limit (mm).
        original: the unmorphed finger, computed by finite elements or else by the surrogate.
        resolved: designs computed again by finite elements.
    """

    front: Points
    cloud: Points | None = None
    failed: int = 0
    chosen: Mapping[float, tuple[float, float]] = field(default_factory=dict)
    original: tuple[float, float] | None = None
    resolved: Points | None = None


def plot_front(picture: FrontPicture, path: Path) -> None:
    """Plot the front with the designs it was learnt from (the paper's Fig. 7d)."""
    with _figure(path, 1) as (axes,):
        if picture.cloud is not None:
            count = len(picture.cloud.cog_mm)
            lost = f"; {picture.failed} failed, not shown" if picture.failed else ""
            axes.plot(
                picture.cloud.cog_mm,
                picture.cloud.force_N,
                "o",
                color=GREY,
                ms=3,
                alpha=0.6,
                mec="none",
                label=f"design of experiments ({count}{lost})",
            )
        size = len(picture.front.cog_mm)
        axes.plot(
            picture.front.cog_mm,
            picture.front.force_N,
            ".",
            color=BLUE,
            ms=3,
            label=f"Pareto front of the surrogate ({size} points)",
        )
        if picture.resolved is not None:
            axes.plot(
                picture.resolved.cog_mm,
                picture.resolved.force_N,
                "D",
                color=INK,
                mfc="none",
                ms=5.5,
                zorder=6,
                label="computed again by finite elements",
            )
        if picture.original is not None:
            axes.plot(
                *picture.original,
                "s",
                color=GREEN,
                mec=INK,
                mew=0.6,
                ms=6,
                zorder=5.5,
                label="original",
            )
        _draw_chosen(axes, picture.chosen)
        axes.set(xlabel=LABELS["cog_offset_mm"], ylabel=LABELS[FORCE.name])
        # the legend stands above: labels of the limits or the cloud may fill any corner
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)


def _draw_chosen(axes: Axes, chosen: Mapping[float, tuple[float, float]]) -> None:
    for number, (limit, (cog, force)) in enumerate(sorted(chosen.items())):
        axes.axvline(limit, color=ORANGE, lw=0.8, ls=":", zorder=1)
        axes.plot(
            cog,
            force,
            "*",
            color=ORANGE,
            mec=INK,
            mew=0.6,
            ms=11,
            zorder=5,
            label="chosen: largest force in a limit" if number == 0 else None,
        )
        # the label runs along its line, so that labels of close limits do not overlap
        axes.annotate(
            f"≤ {limit:g} mm",
            (limit, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(-2, -2),
            textcoords="offset points",
            rotation="vertical",
            ha="right",
            va="top",
            color=ORANGE,
            fontsize=8,
        )


@dataclass(frozen=True)
class Scatter:
    """Standard deviations over seeds for one population, by number of generations.

    Attributes:
        generations: shape (numbers,).
        sd: shape (numbers, inputs).
    """

    generations: npt.NDArray[np.int_]
    sd: Numbers


def plot_scatter(names: Sequence[str], scatter: Mapping[int, Scatter], path: Path) -> None:
    """Plot standard deviations of the chosen inputs against generations (the paper's Fig. 8).

    Args:
        names: names of the inputs; each has a panel.
        scatter: standard deviations by population.
    """
    styles = [(BLUE, "o"), (ORANGE, "s"), (GREEN, "^"), (PURPLE, "D"), (INK, "v"), (GREY, "x")]
    with _figure(path, len(names)) as panels:
        for column, (name, axes) in enumerate(zip(names, panels, strict=True)):
            for number, (population, found) in enumerate(sorted(scatter.items())):
                colour, marker = styles[number % len(styles)]
                axes.plot(
                    found.generations,
                    found.sd[:, column],
                    marker=marker,
                    color=colour,
                    label=f"population {population}",
                    clip_on=False,
                )
            text = LABELS.get(name, name)
            axes.set(xlabel="Generations", ylabel=f"Standard deviation of {text}")
            axes.set_xlim(left=0)
            axes.set_ylim(bottom=0)
            axes.set_title(f"({'abcdefgh'[column % 8]})", loc="left", fontsize=9)
        panels[0].legend(loc="best")


@contextmanager
def _figure(path: Path, panels: int) -> Iterator[list[Axes]]:
    """Panels side by side in one figure, which is saved on leaving."""
    with figure_theme():
        # A Figure of its own, not pyplot's: pyplot would keep it open and choose a backend.
        figure = Figure(figsize=(6.0 if panels == 1 else 4.0 * panels, 4.0), layout="constrained")
        FigureCanvasAgg(figure)
        figure.get_layout_engine().set(wspace=0.06)  # type: ignore[union-attr, call-arg]
        yield list(figure.subplots(1, panels, squeeze=False)[0])
        save(figure, path)
