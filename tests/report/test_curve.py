"""Curves: made, sized, labelled with units, whatever columns there are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure

from dolfingrip.charts.picture import Look, write
from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.blocked_force import BlockedForce
from dolfingrip.experiments.chart import DrawnResult, chart
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.files.run import TurningPoint
from dolfingrip.files.table import Columns

LOADING = [0.0, 50.0, 100.0, 150.0, 200.0, 250.0]
RETURN = [200.0, 150.0, 100.0, 50.0, 0.0]


TURN = TurningPoint(170.0, 1.7, 0.01, 0.02)


def plot(experiment: Experiment, result: Columns, file: Path, **more: Any) -> Path:
    return write([chart(experiment, [DrawnResult(result)], **more)], file, Look(across=1))


def _legend(figure: Figure) -> list[str]:
    legend = figure.axes[0].get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def _clipped(file: Path) -> bool:
    """Whether anything is drawn on the very border of the page."""
    picture = matplotlib.image.imread(file)[..., :3]
    return any(
        bool((side < 0.98).any())
        for side in (picture[:2], picture[-2:], picture[:, :2], picture[:, -2:])
    )


def test_bending_with_both_branches(tmp_path: Path, figures: list[Figure]) -> None:
    pressure = LOADING + RETURN
    result = {
        "pressure_kPa": pressure,
        "branch": ["loading"] * 6 + ["unloading"] * 5,
        "angle_deg": [0.4 * p for p in pressure],
        "chord_angle_deg": [0.2 * p for p in pressure],
    }
    measured = {
        "experiment": ["bending", "blocked_force"],
        "pressure_kPa": [100, 100],
        "angle_deg": [41, None],
        "force_N": [None, 1.0],
    }
    file = plot(Bending(), result, tmp_path / "new" / "curve.png", measured=measured)
    assert matplotlib.image.imread(file).shape[:2] == (1200, 1800)
    (figure,) = figures
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Pressure (kPa)", "Bending angle (°)")
    assert _legend(figure) == [
        "tip face, loading",
        "tip face, unloading",
        "chord, clamp to tip, loading",
        "chord, clamp to tip, unloading",
        "measured",
    ]
    assert not _clipped(file)
    (bar,) = axes.collections[-1].get_segments()  # two standard deviations of 0.3° about 41°
    assert bar.tolist() == [[100.0, 40.4], [100.0, 41.6]]
    unloading = axes.get_lines()[1]
    assert unloading.get_linestyle() == "--"
    assert np.asarray(unloading.get_xdata())[0] == 250.0  # joined at the turn


def test_bending_with_the_least_columns(tmp_path: Path, figures: list[Figure]) -> None:
    plot(Bending(), {"pressure_kPa": ["0", "50"], "angle_deg": ["0", "20"]}, tmp_path / "c.png")
    assert _legend(figures[0]) == ["tip face"]


def test_blocked_force_with_turning_point(tmp_path: Path, figures: list[Figure]) -> None:
    result = {"pressure_kPa": LOADING, "force_N": [0.0, 0.5, 1.0, 1.5, 2.3, 3.3]}
    file = plot(BlockedForce(), result, tmp_path / "curve.png", turning_point=TURN)
    assert matplotlib.image.imread(file).std() > 0.05
    (figure,) = figures
    assert figure.axes[0].get_ylabel() == "Blocked force (N)"
    assert _legend(figure) == [
        "simulation",
        "fit before: 0.0100 N/kPa",
        "fit after: 0.0200 N/kPa",
        "turning point: 170 kPa, 1.70 N",
    ]
    assert not _clipped(file)


def test_blocked_force_without_turning_point(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"pressure_kPa": LOADING, "force_N": LOADING})
    assert plot(BlockedForce(), frame, tmp_path / "curve.png").is_file()


def test_missing_column_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^results have no column force_N$"):
        plot(BlockedForce(), {"pressure_kPa": LOADING, "force_N": [""] * 6}, tmp_path / "c.png")
    with pytest.raises(ValueError, match=r"^results have no column angle_deg$"):
        plot(Bending(), {"pressure_kPa": LOADING}, tmp_path / "c.png")
    assert not list(tmp_path.iterdir())
