"""Bars, points and charts below others as Matplotlib draws them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from dolfingrip.charts import picture
from dolfingrip.charts.chart import Axis, Chart, Series
from dolfingrip.charts.picture import draw

NAMES = Axis("", names=["first", "second"])


def test_a_kind_without_bars_stands_in_the_key() -> None:
    bars = [
        Series("none of these", [], [], "bar", colour="green"),
        Series("these", [0.2, 0.7], [0, 1], "bar", colour="grey", said=["0.20", "0.70"]),
    ]
    axes = Figure().subplots()
    draw(Chart("", Axis("Probability"), NAMES, bars), axes)
    assert axes.get_legend_handles_labels()[1] == ["none of these", "these"]
    assert [bar.get_width() for each in axes.containers for bar in each] == [0.2, 0.7]
    assert [text.get_text() for text in axes.texts] == ["0.20", "0.70"]
    assert axes.get_yticklabels()[0].get_text() == "first"


def test_bars_of_one_place_share_it() -> None:
    bars = [
        Series(name, np.array([1.0, 2.0]), np.array([0, 1]), "bar", low=[0.5, 1.5], high=[1.5, 2.5])
        for name in ("before", "after")
    ]
    axes = Figure().subplots()
    draw(Chart("", Axis("Error"), NAMES, bars), axes)
    (first, _), (second, _) = ([bar.get_y() for bar in each] for each in axes.containers)
    height = axes.containers[0][0].get_height()
    assert second - first == height
    assert 0.7 < 2 * height < 1.0


def test_many_points_have_small_marks_and_none_is_left_out() -> None:
    axes = Figure().subplots()
    few, many = (np.linspace(0.0, 1.0, count) for count in (20, 400))
    series = [Series("few", few, few, "points"), Series("many", many, many, "points")]
    draw(Chart("", Axis("x"), Axis("y"), series), axes)
    large, small = axes.lines
    assert [len(line.get_xdata()) for line in (large, small)] == [20, 400]
    assert all(line.get_marker() == "o" for line in (large, small))
    assert 0 < small.get_markersize() < large.get_markersize() / 2


def test_a_chart_below_stands_on_the_same_axis_with_bars_of_its_own(tmp_path: Path) -> None:
    """Points with ends have a bar each; a chart without one below leaves its place empty."""
    x, y, left = np.array([1.0, 2.0]), np.array([10.0, 20.0]), np.array([0.5, -0.5])
    rest = Series("r", x, left, "points", None, left - 1, left + 1)
    below = Chart("", Axis("p"), Axis("rest"), [rest])
    upper = Chart("", Axis("p", ends=(0.0, 4.0)), Axis("y"), [Series("m", x, y)], below=below)
    saved: list[Figure] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(picture, "save", lambda figure, *_: saved.append(figure))
        picture.write([upper, replace(upper, below=None)], tmp_path / "both.png")
    (figure,) = saved
    first, other, lower, empty = figure.axes
    assert lower.get_xlim() == first.get_xlim() == (0.0, 4.0)
    assert (first.get_xlabel(), lower.get_xlabel(), other.get_xlabel()) == ("", "p", "p")
    assert [each.axison for each in figure.axes] == [True, True, True, False]
    (bars,) = lower.collections
    assert [each.tolist() for each in bars.get_segments()] == [
        [[1.0, -0.5], [1.0, 1.5]], [[2.0, -1.5], [2.0, 0.5]],
    ]  # fmt: skip
    assert not empty.has_data()
