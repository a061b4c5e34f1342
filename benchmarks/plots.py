"""Time against dofs, and error against time (work–precision)."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from benchmarks.convergence import QUANTITIES, limits, series
from benchmarks.orders import exponent
from benchmarks.outcomes import Outcome
from dolfingrip.charts import theme

COLOURS = {"S2": theme.GREEN, "P2": theme.BLUE, "P1": theme.ORANGE}
MARKERS = {"S2": "^", "P2": "o", "P1": "s"}


def growth_points(outcome: Outcome, element: str) -> list[tuple[float, float, float]]:
    """Dofs, seconds of processor time and MB of each mesh, by dofs."""
    labels = [label for label in outcome.runs if label.split()[0] == element]
    points = [
        tuple(outcome.median(label, key) for key in ("dofs", "processor_s", "peak_MB"))
        for label in labels
    ]
    return sorted(points)  # type: ignore[arg-type]


def draw(found: dict[str, Outcome], folder: Path) -> None:
    """Draw what there are outcomes for."""
    if "growth" in found:
        _draw_growth(found["growth"], folder / "time_dofs.png")
    if "convergence" in found:
        _draw_precision(found["convergence"], folder / "error_time.png")


def _draw_growth(outcome: Outcome, path: Path) -> None:
    with theme.figure_theme():
        figure, axes = plt.subplots(figsize=(4.2, 3.2), layout="constrained")
        for element, colour in COLOURS.items():
            points = np.array(growth_points(outcome, element))
            if len(points) < 2:
                continue
            dofs, seconds = points[:, 0], points[:, 1]
            label = f"{element}: dofs$^{{{exponent(dofs, seconds):.2f}}}$"
            axes.loglog(dofs, seconds, MARKERS[element] + "-", color=colour, label=label)
        axes.set(xlabel="displacement dofs", ylabel="processor time (s)")
        axes.set_title("Free bending to 50 kPa, one core", fontsize=9)
        axes.legend()
        figure.savefig(path)
        plt.close(figure)


def _draw_precision(outcome: Outcome, path: Path) -> None:
    best = limits(outcome)
    with theme.figure_theme():
        figure, panels = plt.subplots(1, 2, figsize=(7.2, 3.2), layout="constrained")
        for axes, (kind, quantity) in zip(panels, QUANTITIES.items(), strict=True):
            for name, colour, marker in (
                ("S2 uniform", theme.GREEN, "^"),
                ("S2 ungraded", theme.GREEN, "v"),
                ("P2 uniform", theme.BLUE, "o"),
                ("P1 uniform", theme.ORANGE, "s"),
                ("P2-P1 uniform", theme.PURPLE, "D"),
            ):
                points = series(outcome, kind, name)
                if not points or kind not in best:
                    continue
                error = [abs(p.value / best[kind].value - 1) * 100 for p in points]
                seconds = [p.seconds for p in points]
                line = "--" if name.endswith("graded") else "-"
                label = "S2" if name == "S2 uniform" else name.removesuffix(" uniform")
                axes.loglog(seconds, error, marker + line, color=colour, label=label)
            if kind in best:
                floor = best[kind].uncertainty / abs(best[kind].value) * 100
                axes.axhspan(1e-4, floor, color=theme.PALE, alpha=0.5, lw=0)
                axes.set_ylim(bottom=max(floor / 3, 1e-3))
            axes.axhline(1.0, color=theme.GREY, lw=0.8, ls="--")
            axes.set(xlabel="processor time (s)", ylabel=f"error of the {quantity.name} (%)")
            axes.legend()
        figure.savefig(path)
        plt.close(figure)
