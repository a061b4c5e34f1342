"""Picture of a plan: each effect's strength, the strength from which it is named, additions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from dolfingrip.report.theme import BLUE, GREEN, GREY, INK, ORANGE, PALE, figure_theme, save


@dataclass(frozen=True, slots=True)
class PlanPicture:
    """How the picture of a plan is drawn.

    Attributes:
        faintest_sigma: strength (σ) below which a bar ends.
        row_in: height of an effect's line, in inches.
    """

    faintest_sigma: float = 0.3
    row_in: float = 0.19


PICTURE: Final = PlanPicture()


START = PICTURE.faintest_sigma / 3
"""Strength (σ) at which bars begin, outside the picture."""


def draw(plan: Mapping[str, Any], file: Path) -> Path:
    """Draw a plan.

    Args:
        plan: ``effects`` with effect, strength_sigma, named_from_sigma, share, class_share;
            ``additions`` with name, share, minutes, gain_per_minute; ``share``.
        file: PNG to write.
    """
    effects, additions = plan["effects"], plan["additions"]
    lines = max(len(effects), 2 * len(additions) + 4)
    with figure_theme():
        figure = Figure(figsize=(11.0, 1.1 + PICTURE.row_in * lines), layout="constrained")
        FigureCanvasAgg(figure)
        left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
        _effects(left, effects)
        _additions(right, additions, plan["share"])
        save(figure, file, dpi=130)
    return file


def _effects(ax: Axes, effects: list[dict[str, Any]]) -> None:
    rows = list(reversed(effects))
    colours = [
        GREEN if each["share"] >= 0.5 else BLUE if each["class_share"] >= 0.5 else PALE
        for each in rows
    ]
    names = [each["effect"].replace("_", " ") for each in rows]
    ends = [max(each["strength_sigma"], PICTURE.faintest_sigma) for each in rows]
    ax.barh(names, [end - START for end in ends], left=START, color=colours)
    first = True
    for place, each in enumerate(rows):
        if each["named_from_sigma"] is not None:
            ax.plot(each["named_from_sigma"], place, "|", color=INK, ms=9, mew=1.6,
                    label="named alone from here on" if first else None)  # fmt: skip
            first = False
    for colour, label in ((GREEN, "named alone in half of cases or more"),
                          (BLUE, "its class is"), (PALE, "neither")):  # fmt: skip
        ax.barh([names[0]], [0], color=colour, label=label)
    ax.set(xscale="log", xlim=(PICTURE.faintest_sigma, None), ylim=(-0.7, len(rows) - 0.3),
           xlabel="Change of the readings by an ordinary strength (σ)")  # fmt: skip
    ax.tick_params(axis="y", labelsize=7)
    ax.grid(axis="y", visible=False)
    ax.legend(loc="lower right", fontsize=7)


def _additions(ax: Axes, additions: list[dict[str, Any]], share: float) -> None:
    rows = sorted(additions, key=lambda each: each["share"])
    names = [f"{each['name']} ({each['minutes']:.0f} min)" for each in rows]
    ax.barh(names, [100 * each["share"] for each in rows], color=ORANGE, height=0.6)
    ax.axvline(100 * share, color=INK, lw=1.0, ls="--", label="the rig as it is")
    for place, each in enumerate(rows):
        ax.text(100 * each["share"] + 1, place, f"{100 * each['gain_per_minute']:+z.2f} % a minute",
                va="center", fontsize=7, color=GREY)  # fmt: skip
    ax.set(xlabel="Effects that are named (%)", xlim=(0, 100))
    ax.tick_params(axis="y", labelsize=7)
    ax.grid(axis="y", visible=False)
    ax.legend(loc="lower right", fontsize=7)
