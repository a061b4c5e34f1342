"""How far a campaign is: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from dolfingrip.design.campaign.campaign import Standing

EVERY_S = 30.0
"""Time between two lines where there is no terminal."""

FEW = 60
"""A campaign of no more designs than these has a line for each of them."""


class Pace:
    """Rate and time left, from the answers of this call."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._start = clock()

    def text(self, standing: Standing) -> str:
        """E.g. ``5.9 a minute, 0:27:10 left, 3 failed``."""
        parts = []
        elapsed = self._clock() - self._start
        if standing.computed and elapsed > 0:
            rate = standing.computed / elapsed
            parts.append(f"{60 * rate:.1f} a minute")
            if standing.missing:
                parts.append(f"{_duration(standing.missing / rate)} left")
        parts.append(f"{standing.failed} failed")
        return ", ".join(parts)


@contextmanager
def shown(console: Console) -> Iterator[Callable[[Standing], None]]:
    """What to call with each new standing."""
    pace = Pace()
    if not console.is_terminal:
        yield _Lines(console, pace)
        return
    columns = (
        TextColumn("designs"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[note]}"),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("", total=None, note="")

        def advance(standing: Standing) -> None:
            bar.update(
                task,
                total=standing.total,
                completed=standing.done + standing.failed,
                note=pace.text(standing),
            )

        yield advance


class _Lines:
    """A line at the start, then one for each design of a few, or one every half minute."""

    def __init__(self, console: Console, pace: Pace) -> None:
        self._console, self._pace = console, pace
        self._last = -EVERY_S

    def __call__(self, standing: Standing) -> None:
        now = time.monotonic()
        if standing.total > FEW and now - self._last < EVERY_S:
            return
        self._last = now
        ready = standing.done + standing.failed
        self._console.print(
            f"{ready} of {standing.total} designs, {self._pace.text(standing)}", soft_wrap=True
        )


def _duration(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{seconds:02d}"
