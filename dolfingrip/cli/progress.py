"""The progress of a command: a bar on a terminal, else a line every :data:`EVERY_S` seconds."""

from __future__ import annotations

import textwrap
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from statistics import median_low
from typing import TYPE_CHECKING, Protocol

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column

if TYPE_CHECKING:
    from dolfingrip.jobs.job import JobResult
    from dolfingrip.jobs.run import Standing

EVERY_S = 30.0
"""Time between two lines where there is no terminal."""

WIDEST = 100
"""Characters of a line there; a longer one goes on in the next."""

FEW = 50
"""A campaign of no more designs than these has a line for each of them."""


class Show(Protocol):
    """A function that shows the number done, the number of all and a note."""

    def __call__(self, done: int, total: int, note: str = "", computed: int | None = None) -> None:
        """Show them.

        Args:
            done: number done.
            total: number of all.
            note: text that is shown after them.
            computed: of those done, the ones that this call computed; all of them where None.
        """


class Pace:
    """Rate and time left, from what was computed since the first call.

    What was there before has no part in the rate. Where less is computed than at the first call,
    other work has begun, and the rate begins anew.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._first: tuple[float, int] | None = None

    def text(self, done: int, total: int, computed: int | None = None) -> str:
        """E.g. ``5.9 a minute, 0:27:10 left``; nothing at first."""
        now, computed = self._clock(), done if computed is None else computed
        if self._first is None or computed <= self._first[1]:
            self._first = (now, computed)
        start, before = self._first
        if computed == before or now <= start:
            return ""
        rate_per_s = (computed - before) / (now - start)
        text = f"{60 * rate_per_s:.1f} a minute"
        return text if done == total else f"{text}, {_duration((total - done) / rate_per_s)} left"


class Forecast:
    """Time left of an experiment, from what its readings are expected to cost.

    A reading's cost is its time by its effort. The lower median of all costs so far is taken, as
    forms that are compiled on the way or another load of the machine make a few readings slower.
    Nothing is said before ``LEAST`` readings are timed, and while a reading takes ``LATE`` times
    what it should, as where load steps fail. The first reading is not timed, since it comes after
    the mesh is made and the forms are compiled.

    Args:
        efforts: expected effort of each reading, in any unit.
        clock: in seconds.
    """

    LEAST = 2
    LATE = 3.0

    def __init__(
        self, efforts: Sequence[float], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._efforts = list(efforts)
        self._clock = clock
        self._last: tuple[int, float] | None = None
        self._costs: list[float] = []

    def text(self, done: int, total: int, computed: int | None = None) -> str:
        """E.g. ``0:01:10 left``; nothing at first."""
        now = self._clock()
        if self._last is not None and done > self._last[0]:
            effort = sum(self._efforts[self._last[0] : done])
            if effort > 0:
                self._costs.append((now - self._last[1]) / effort)
        if self._last is None or done > self._last[0]:
            self._last = (done, now)
        left = sum(self._efforts[done:])
        if len(self._costs) < self.LEAST or left <= 0:
            return ""
        cost, since = median_low(self._costs), now - self._last[1]
        late = since > self.LATE * cost * self._efforts[done]
        return "" if late else f"{_duration(cost * left)} left"


@contextmanager
def shown(
    console: Console,
    what: str,
    *,
    total: int | None = None,
    note: str = "",
    at_once: bool = False,
    few: int = 0,
    clock: Callable[[], float] = time.monotonic,
    pace: Pace | Forecast | None = None,
) -> Iterator[Show]:
    """Yield the function to call as a command goes on.

    Args:
        console: where it is shown.
        what: is counted, in the plural.
        total: number of all, where it is known before the first call.
        note: text that is shown after the bar until the first call.
        at_once: the first call makes a line where there is no terminal.
        few: each call makes a line there where the number of all is no larger than this.
        clock: in seconds.
        pace: tells rate and time left; default: those since the first call.
    """
    pace = pace or Pace(clock)
    if not console.is_terminal:
        last = clock() - (EVERY_S if at_once else 0)

        def say(done: int, total: int, note: str = "", computed: int | None = None) -> None:
            nonlocal last
            speed = pace.text(done, total, computed)
            if total <= few or clock() - last >= EVERY_S:
                last = clock()
                text = _joined(f"{done} of {total} {what}", speed, note)
                lines = textwrap.wrap(text, WIDEST, subsequent_indent="    ")
                console.print("\n".join(lines), soft_wrap=True)

        yield say
        return
    columns = (
        TextColumn(what, markup=False),
        BarColumn(bar_width=None, table_column=Column(ratio=1)),  # what the others leave
        MofNCompleteColumn(),
        TextColumn("{task.fields[note]}", markup=False),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, expand=True) as bar:
        task = bar.add_task("", total=total, note=note)

        def draw(done: int, total: int, note: str = "", computed: int | None = None) -> None:
            text = _joined(note, pace.text(done, total, computed))
            bar.update(task, completed=done, total=total, note=text)

        yield draw


@contextmanager
def jobs(
    console: Console,
    what: str,
    few: int = 0,
    clock: Callable[[], float] = time.monotonic,
    describe: Callable[[JobResult], str] = lambda answer: "",
) -> Iterator[Callable[[Standing], None]]:
    """Yield the function to call with each new standing of jobs.

    Args:
        console: where it is shown.
        what: is counted, in the plural.
        few, clock: see :func:`shown`.
        describe: says in words what the latest answer is.
    """
    with shown(console, what, at_once=True, few=few, clock=clock) as show:

        def tell(standing: Standing) -> None:
            latest = "" if standing.latest is None else describe(standing.latest)
            tried = standing.again + standing.broken
            again = f"{tried} attempts broken off by the machine" if tried else ""
            show(
                standing.done + standing.failed,
                standing.total,
                _joined(f"{standing.failed} failed", again, latest),
                standing.computed,
            )

        yield tell


def _joined(*parts: str) -> str:
    return ", ".join(part for part in parts if part)


def _duration(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{seconds:02d}"
