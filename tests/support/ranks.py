"""Ranks that are ended by SIGKILL while they compute."""

from __future__ import annotations

import os
import random
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from dolfingrip.experiments.simulate import MODULE

STEP_S = 0.05


@contextmanager
def killed_ranks(chosen: Callable[[int], float | None], seed: int = 0) -> Iterator[list[int]]:
    """Kill one rank of some of the runs of mpirun that this process makes.

    Args:
        chosen: from the number of runs before to the seconds after which a rank is killed; None:
            all ranks of this run live.
        seed: of the choice among the ranks.

    Yields:
        Processes that were killed; it grows.
    """
    killed: list[int] = []
    over = threading.Event()
    rng = random.Random(seed)

    def watch() -> None:
        due: dict[int, float] = {}
        while not over.wait(STEP_S):
            for parent, ranks in _runs().items():
                if parent not in due:
                    wait = chosen(len(due))
                    due[parent] = float("inf") if wait is None else time.monotonic() + wait
                if time.monotonic() >= due[parent]:
                    due[parent] = float("inf")
                    with suppress(ProcessLookupError):  # it has just ended
                        os.kill(one := rng.choice(ranks), signal.SIGKILL)
                        killed.append(one)

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield killed
    finally:
        over.set()
        thread.join()


def _runs() -> dict[int, list[int]]:
    """Ranks by the mpirun that this process or one of its children made."""
    parents: dict[int, int] = {}
    ranks: list[int] = []
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, ValueError):
            parents[int(folder.name)] = int(
                (folder / "stat").read_text().rpartition(")")[2].split()[1]
            )
            words = (folder / "cmdline").read_bytes().split(b"\0")
            if MODULE.encode() in words and b"-n" not in words:
                ranks.append(int(folder.name))
    found: dict[int, list[int]] = {}
    for rank in sorted(ranks):
        above = rank
        while above and above != os.getpid():
            above = parents.get(above, 0)
        if above:
            found.setdefault(parents[rank], []).append(rank)
    return found
