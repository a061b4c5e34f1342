"""What is shown of how far a command is, on a terminal and elsewhere."""

from __future__ import annotations

import io
from collections.abc import Iterator

import pytest
from rich.console import Console

from dolfingrip import config
from dolfingrip.cli import progress
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.jobs.run import Standing
from dolfingrip.sections.tables import assignments


def times(*values: float) -> Iterator[float]:
    """Moments of a clock, the last for ever."""
    yield from values
    while True:
        yield values[-1]


def screen(*, terminal: bool) -> Console:
    return Console(file=io.StringIO(), force_terminal=terminal, width=80, highlight=False)


def said(console: Console) -> str:
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def test_pace() -> None:
    clock = times(0.0, 120.0)
    pace = progress.Pace(lambda: next(clock))
    assert pace.text(5, 60) == ""
    assert pace.text(15, 60) == "5.0 a minute, 0:09:00 left"
    assert pace.text(60, 60) == "27.5 a minute"


def test_what_was_there_before_has_no_part_in_the_rate() -> None:
    """Batches of a diagnosis that resumes: the same number of all, of which fewer are done.

    The rate was the difference of what was done, and came out negative.
    """
    now = [0.0]
    pace = progress.Pace(lambda: now[0])
    assert pace.text(20, 24, 0) == ""
    now[0] = 60.0
    assert pace.text(22, 24, 2) == "2.0 a minute, 0:01:00 left"
    now[0] = 120.0
    assert pace.text(6, 24, 0) == ""  # the next batch: nothing of it has been computed
    now[0] = 180.0
    assert pace.text(9, 24, 3) == "3.0 a minute, 0:05:00 left"
    now[0] = 240.0
    assert pace.text(24, 24, 0) == ""  # all of this batch was there
    now[0] = 300.0
    assert pace.text(21, 24, 0) == ""
    now[0] = 330.0
    assert pace.text(22, 24, 1) == "2.0 a minute, 0:01:00 left"


@pytest.mark.parametrize("terminal", [True, False])
def test_resumed_batches_on_a_terminal_and_elsewhere(terminal: bool) -> None:
    """The standing says what was computed, and both displays count that alone."""
    now = [0.0]
    console = screen(terminal=terminal)
    with progress.jobs(console, "simulations", few=99, clock=lambda: now[0]) as show:
        for second, done, computed in ((0.0, 20, 0), (60.0, 22, 2), (120.0, 6, 0), (180.0, 9, 3)):
            now[0] = second
            show(Standing(total=24, done=done, computed=computed))
    last = [line for line in said(console).splitlines() if "24" in line][-1]
    assert "3.0 a minute, 0:05:00 left" in last
    assert "-" not in last


def test_lines_where_there_is_no_terminal() -> None:
    now = [0.0]
    console = screen(terminal=False)
    with progress.shown(console, "epochs", clock=lambda: now[0]) as show:
        for done, second in ((1, 0.0), (20, 20.0), (41, 40.0), (50, 50.0), (81, 80.0)):
            now[0] = second
            show(done, 100, "training")
    assert said(console).splitlines() == [
        "41 of 100 epochs, 60.0 a minute, 0:00:59 left, training",
        "81 of 100 epochs, 60.0 a minute, 0:00:19 left, training",
    ]


def test_a_long_line_goes_on_in_the_next_where_there_is_no_terminal() -> None:
    """No word is lost; 230 characters came before."""
    console = screen(terminal=False)
    note = ", ".join(f"bounded by part {i}" for i in range(12))
    with progress.shown(console, "readings", at_once=True) as show:
        show(1, 9, note)
    lines = said(console).splitlines()
    assert max(map(len, lines)) <= progress.WIDEST
    assert " ".join(line.strip() for line in lines) == f"1 of 9 readings, {note}"


def test_a_campaign_says_at_once_how_far_it_was() -> None:
    console = screen(terminal=False)
    with progress.jobs(console, "designs", progress.FEW) as show:
        show(Standing(total=60, done=5, failed=3))
        show(Standing(total=60, done=6, failed=3, computed=1))
    assert said(console).splitlines() == ["8 of 60 designs, 3 failed"]


def test_a_small_campaign_has_a_line_for_each_design() -> None:
    console = screen(terminal=False)
    with progress.jobs(console, "designs", progress.FEW) as show:
        for done in range(3):
            show(Standing(total=30, done=done, computed=done))
    lines = [line.partition(",")[0] for line in said(console).splitlines()]
    assert lines == [f"{done} of 30 designs" for done in range(3)]


def test_bar_on_a_terminal() -> None:
    now = [0.0]
    console = screen(terminal=True)
    with progress.shown(console, "designs", total=60, note="mesh", clock=lambda: now[0]) as show:
        show(5, 60)
        now[0] = 120.0
        show(15, 60, "3 failed")
    last = [line for line in said(console).splitlines() if "━" in line][-1]
    assert "designs" in last
    assert "15/60" in last
    assert "3 failed, 5.0 a minute, 0:09:00 left" in last


LOADING_S, WAIT_S, LIFT_S = (6.3, 7.8, 8.4, 11.8), 1.3, (14.2, 8.4, 7.3, 7.7, 8.2, 16.4)
"""Times of the readings of a grasp (cube, 100 kPa, coarse preset) on a machine with other work."""


@pytest.mark.parametrize("compiled_s", [0.0, 40.0])
def test_a_grasp_foretells_its_time(compiled_s: float) -> None:
    """Forms are compiled on the way to the second reading, which once made 96 s nine minutes."""
    asked = config.load(
        None, assignments(["experiment.max_pressure_kPa=100", "experiment.step_kPa=25"])
    )
    grasp = EXPERIMENTS["grasp"]
    efforts = grasp.efforts(grasp.settings(asked))
    took = [LOADING_S[0] + compiled_s, *LOADING_S[1:], WAIT_S, *LIFT_S, 3.0]
    assert len(efforts) == 1 + len(took)
    now = [0.0]
    forecast = progress.Forecast(efforts, lambda: now[0])
    assert forecast.text(1, len(efforts)) == ""
    for done, each in enumerate(took, 2):
        now[0] += each
        said = forecast.text(done, len(efforts))
        if done == 2 or done == len(efforts):
            assert said == ""
            continue
        hours, minutes, seconds = map(int, said.removesuffix(" left").split(":"))
        foretold = 3600 * hours + 60 * minutes + seconds
        truth = sum(took[done - 1 :])
        assert foretold == pytest.approx(truth, rel=0.45, abs=12)


def test_what_is_told_between_readings_is_no_reading() -> None:
    """The time between two readings counts whole, whatever is shown on the way."""
    now = [0.0]
    forecast = progress.Forecast([1, 1, 1, 1], clock=lambda: now[0])
    for moment, done in ((0.0, 1), (5.0, 1), (10.0, 2), (15.0, 2), (20.0, 3)):
        now[0] = moment
        text = forecast.text(done, 4)
    assert text == "0:00:10 left"


def test_nothing_is_foretold_while_a_reading_takes_far_longer_than_it_should() -> None:
    """As where load steps are halved; three readings of 5 s each, the fourth does not come."""
    now = [0.0]
    forecast = progress.Forecast([1, 1, 1, 1, 1], clock=lambda: now[0])
    for done in (1, 2, 3):
        now[0] = 5.0 * (done - 1)
        forecast.text(done, 5)
    now[0] = 24.0
    assert forecast.text(3, 5) == "0:00:10 left"
    now[0] = 26.0
    assert forecast.text(3, 5) == ""
