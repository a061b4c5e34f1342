"""Pictures of the design loop: made, labelled with units, failed designs counted and not drawn."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
from matplotlib.figure import Figure

from dolfingrip.report.design import (
    FrontPicture,
    Points,
    Scatter,
    plot_fit,
    plot_front,
    plot_learning_curve,
    plot_scatter,
)


def _legend(figure: Figure) -> list[str]:
    legend = figure.axes[0].get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def _unclipped(file: Path) -> bool:
    """Whether the very border of the page is empty."""
    picture = matplotlib.image.imread(file)[..., :3]
    sides = (picture[:2], picture[-2:], picture[:, :2], picture[:, -2:])
    return all(bool((side > 0.98).all()) for side in sides)


def test_learning_curve(tmp_path: Path, figures: list[Figure]) -> None:
    epoch = np.arange(0, 5001, 10)
    mse = np.exp(-epoch / 500.0)
    file = tmp_path / "curve.png"
    plot_learning_curve(epoch, mse, 2 * mse, file, goal=1e-3)
    assert _legend(figures[0]) == ["training, last 4.5e-05", "test, last 9.1e-05", "goal, 0.001"]
    assert figures[0].axes[0].get_yscale() == "log"
    assert _unclipped(file)


def test_fit_has_a_panel_for_each_output(tmp_path: Path, figures: list[Figure]) -> None:
    computed = np.array([[1.0, 5.0], [2.0, 6.0], [3.0, 7.0]])
    test = np.array([False, True, False])
    plot_fit(["cog_offset_mm", "force_N"], computed, computed + 0.1, test, tmp_path / "fit.png")
    assert _legend(figures[0]) == ["training", "test, RMS error 0.1 mm"]
    assert [axes.get_xlabel() for axes in figures[0].axes] == [
        "COG offset (mm), finite elements",
        "Blocked force (N), finite elements",
    ]


def test_front_tells_what_it_does_not_show(tmp_path: Path, figures: list[Figure]) -> None:
    line = np.linspace(1.0, 8.0, 30)
    picture = FrontPicture(
        Points(line, np.sqrt(line)),
        Points(line, np.sqrt(line) - 0.5),
        failed=4,
        chosen={3.0: (2.9, 1.7)},
        original=(2.8, 1.5),
        resolved=Points(line[::3], np.sqrt(line[::3])),
    )
    plot_front(picture, tmp_path / "front.png")
    assert _legend(figures[0]) == [
        "design of experiments (30; 4 failed, not shown)",
        "Pareto front of the surrogate (30 points)",
        "computed again by finite elements",
        "original",
        "chosen: largest force in a limit",
    ]
    assert figures[0].axes[0].get_xlabel() == "COG offset (mm)"
    assert _unclipped(tmp_path / "front.png")
    plot_front(FrontPicture(Points(line, np.sqrt(line))), tmp_path / "alone.png")
    assert _legend(figures[1]) == ["Pareto front of the surrogate (30 points)"]


def test_scatter_has_a_line_for_each_population(tmp_path: Path, figures: list[Figure]) -> None:
    generations = np.array([10, 50, 100, 200])
    one = Scatter(generations, np.outer(1 / generations, [1.0, 2.0]))
    file = tmp_path / "scatter.png"
    plot_scatter(["morph.xi1", "morph.xi2"], {1000: one, 50: one}, file)
    assert _legend(figures[0]) == ["population 50", "population 1000"]
    assert figures[0].axes[1].get_ylabel() == "Standard deviation of ξ₂"
    assert _unclipped(file)
