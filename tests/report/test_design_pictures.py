"""Pictures of the design loop: made, labelled with units, failed designs counted and not drawn."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
from matplotlib.figure import Figure

from dolfingrip.charts.picture import Look, write
from dolfingrip.files.objective import NamedObjective
from dolfingrip.files.optimum import ChosenDesign, FrontDesign, OptimumFile
from dolfingrip.files.surrogate import LearntDesign
from dolfingrip.report.design import fit, learning_curve, scatter, surrogate_front

OBJECTIVES = (
    NamedObjective(name="cog_offset_mm", unit="mm", sense="at most"),
    NamedObjective(name="force_N", unit="N", sense="maximise"),
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
    learnt = {"epoch": epoch, "training_mse": mse, "test_mse": 2 * mse}
    write([learning_curve(learnt, 1e-3)], file)
    assert _legend(figures[0]) == ["training, last 4.5e-05", "test, last 9.1e-05", "goal, 0.001"]
    assert figures[0].axes[0].get_yscale() == "log"
    assert _unclipped(file)


def test_fit_has_a_panel_for_each_output(tmp_path: Path, figures: list[Figure]) -> None:
    computed = np.array([[1.0, 5.0], [2.0, 6.0], [3.0, 7.0]])
    test = np.array([False, True, False])
    charts = fit(["cog_offset_mm", "force_N"], computed, computed + 0.1, test)
    write(charts, tmp_path / "fit.png")
    assert _legend(figures[0]) == ["training", "test, RMS error 0.1 mm"]
    assert [axes.get_xlabel() for axes in figures[0].axes] == [
        "COG offset (mm), finite elements",
        "Blocked force (N), finite elements",
    ]


def test_front_tells_what_it_does_not_show(tmp_path: Path, figures: list[Figure]) -> None:
    line = np.linspace(1.0, 8.0, 30).tolist()
    every = [{"cog_offset_mm": x, "force_N": float(np.sqrt(x))} for x in line]
    front = [
        FrontDesign(inputs={}, surrogate=values, fem=None if i % 3 else values)
        for i, values in enumerate(every)
    ]
    chosen = ChosenDesign(
        role="chosen", limit=3.0, inputs={}, surrogate={"cog_offset_mm": 2.9, "force_N": 1.7}
    )
    original = ChosenDesign(role="original", inputs={}, fem={"cog_offset_mm": 2.8, "force_N": 1.5})
    alone = OptimumFile(
        objectives=OBJECTIVES, settings={}, surrogate_sha256="", designs=(),
        front=tuple(each.model_copy(update={"fem": None}) for each in front),
    )  # fmt: skip
    whole = alone.model_copy(update={"front": tuple(front), "designs": (chosen, original)})
    learnt = [LearntDesign(inputs={}, outputs=values, predicted={}) for values in every]
    look = Look(across=1, key="above")
    write([surrogate_front(whole, 4, learnt)], tmp_path / "front.png", look)
    assert _legend(figures[0]) == [
        "design of experiments (30; 4 failed, not shown)",
        "Pareto front of the surrogate (30 points)",
        "computed again by finite elements",
        "original",
        "chosen: largest force in a limit",
    ]
    assert figures[0].axes[0].get_xlabel() == "COG offset (mm)"
    assert _unclipped(tmp_path / "front.png")
    write([surrogate_front(alone)], tmp_path / "alone.png")
    assert _legend(figures[1]) == ["Pareto front of the surrogate (30 points)"]


def test_scatter_has_a_line_for_each_population(tmp_path: Path, figures: list[Figure]) -> None:
    generations = [10, 50, 100, 200]
    one = generations, np.outer(1 / np.array(generations), [1.0, 2.0])
    file = tmp_path / "scatter.png"
    write(scatter(["morph.xi1", "morph.xi2"], {1000: one, 50: one}), file)
    assert _legend(figures[0]) == ["population 50", "population 1000"]
    assert figures[0].axes[1].get_ylabel() == "Standard deviation of ξ₂"
    assert _unclipped(file)
