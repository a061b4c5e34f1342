"""Charts as data, and how lines, branches, marks and axes of them are drawn."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from dolfingrip.charts import theme
from dolfingrip.charts.chart import Axis, Chart, Mark, Series, runs
from dolfingrip.charts.picture import COLOURS, draw

LINE = Series("model", [0.0, 1.0, 2.0], [0.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("mask", "expected"),
    [
        ("", []), ("...", []), ("xxx", [(0, 3)]), ("x..xx.x", [(0, 1), (3, 5), (6, 7)]),
        (".x.", [(1, 2)]),
    ],
)  # fmt: skip
def test_runs_of_true_values(mask: str, expected: list[tuple[int, int]]) -> None:
    values = np.array([letter == "x" for letter in mask], dtype=bool)
    assert [(run.start, run.stop) for run in runs(values)] == expected


def test_branches_meet_at_the_turn_and_stand_once_in_the_key() -> None:
    """A line goes on from the last point of the branch before, without a mark there again."""
    branches = ["loading"] * 3 + ["unloading"] * 2 + ["loading"] * 2
    x = np.array([0.0, 1, 2, 1, 0, 1, 2])
    axes = Figure().subplots()
    draw(Chart("", Axis("x"), Axis("y"), [Series("m", x, 2 * x, branches=branches)]), axes)
    first, again, down = axes.lines
    assert first.get_xdata().tolist() == [0, 1, 2]
    assert again.get_xdata().tolist() == [0, 1, 2]
    assert down.get_xdata().tolist() == [2, 1, 0]
    assert (first.get_linestyle(), down.get_linestyle()) == ("-", "--")
    assert down.get_markevery().indices(3) == (1, 3, 1)
    assert axes.get_legend_handles_labels()[1] == ["m, loading", "m, unloading"]


def test_measured_branches_have_marks_of_their_own() -> None:
    points = Series("b", [0.0, 1.0, 2.0], [0.0, 1.0, 0.5], "points",
                    branches=["loading", "hold", "unloading"])  # fmt: skip
    axes = Figure().subplots()
    draw(Chart("", Axis("x"), Axis("y"), [points]), axes)
    assert [line.get_marker() for line in axes.lines] == ["o", "^", "s"]
    assert [len(line.get_xdata()) for line in axes.lines] == [1, 1, 1]


def test_colours_that_are_taken_are_left_out() -> None:
    """By a series of the chart, and by what stands on the axes already; a part has its whole's."""
    axes = Figure().subplots()
    part = Series("", [0.0, 1.0], [1.0, 1.0])
    draw(Chart("", Axis("x"), Axis("y"), [LINE, part, Series("b", [0], [0], colour="green")]), axes)
    draw(Chart("", Axis("x"), Axis("y"), [LINE]), axes)
    colours = [to_hex(line.get_color()) for line in axes.lines]
    expected = [COLOURS[name].lower() for name in ("blue", "blue", "green", "orange")]
    assert colours == expected


def test_marks_are_lines_and_spans_in_the_key_or_beside() -> None:
    marks = [Mark(1.5, "limit"), Mark(0.5, "fit", "x", to=1.0), Mark(2.0, "break", beside=True)]
    axes = Figure().subplots()
    draw(Chart("", Axis("x"), Axis("y"), [LINE], marks), axes)
    _, limit, breaking = axes.lines
    assert limit.get_ydata()[0] == 1.5
    assert breaking.get_ydata()[0] == 2.0
    (span,) = axes.patches
    assert (span.get_x(), span.get_width()) == (0.5, 0.5)
    assert axes.get_legend_handles_labels()[1] == ["model", "limit", "fit"]
    assert [text.get_text() for text in axes.texts] == ["break"]


@pytest.mark.parametrize(
    ("axis", "lowest"), [(Axis("y", zero=True), 0.0), (Axis("y", ends=(-1.0, 5.0)), -1.0)]
)
def test_an_axis_begins_where_it_says(axis: Axis, lowest: float) -> None:
    axes = Figure().subplots()
    draw(Chart("", Axis("x"), axis, [Series("m", [0.0, 1.0], [1.0, 3.0])]), axes)
    assert axes.get_ylim()[0] == lowest
    below = Figure().subplots()
    draw(Chart("", Axis("x"), Axis("y", zero=True), [Series("m", [0, 1], [-2.0, 3.0])]), below)
    assert below.get_ylim()[0] < -2.0


def test_a_chart_in_words() -> None:
    chart = Chart("Bending", Axis("Pressure (kPa)"), Axis("Angle (°)"), [LINE])
    assert chart.description == (
        "Bending: Angle (°) over Pressure (kPa). The table below has the numbers."
    )
    assert Chart("", Axis(""), Axis(""), [], alt="a finger").description == "a finger"


def lightness(colour: tuple[float, ...]) -> float:
    """Relative luminance of sRGB (IEC 61966-2-1)."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour[:3]]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("quantity", [*theme.COLOUR_MAPS])
def test_colour_maps_run_from_light_to_dark(quantity: str) -> None:
    """So that they can be read in grey print; neither end is paper or ink."""
    colours = theme.colour_map(quantity)(np.linspace(0, 1, 50))
    levels = np.array([lightness(tuple(colour)) for colour in colours])
    assert (np.diff(levels) < 1e-6).all()
    assert 0.7 < levels[0] < 0.99
    assert 0.005 < levels[-1] < 0.25


def test_a_tint_is_a_fifth_of_the_colour_on_white() -> None:
    assert theme.tint("#000000") == pytest.approx((0.8, 0.8, 0.8))
    assert theme.tint("#ffffff") == pytest.approx((1.0, 1.0, 1.0))
    assert theme.tint(theme.BLUE)[2] == pytest.approx(1 - 0.2 * (1 - 0xB2 / 0xFF))
