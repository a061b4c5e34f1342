"""The progress of a mesh that another library makes in one call, and an end to its time."""

from __future__ import annotations

import os
import sys
import threading
import time
from pathlib import Path
from types import TracebackType

from rich.console import Console
from rich.text import Text

from dolfingrip.cli.progress import EVERY_S


class Meshing:
    """A context that says what is meshed and since when, and ends the process after a limit.

    The library cannot be interrupted, so the process ends. Nothing is written before.

    Args:
        screen: a terminal has a line that changes; else there is a line every ``EVERY_S`` seconds.
        part: the file.
        limit_s: time after which one line says what to change, and the exit code is 2.
    """

    def __init__(self, screen: Console, part: Path, limit_s: float) -> None:
        self._screen, self._part, self._limit_s = screen, part, limit_s
        self._said = "the part is read"
        self._ended = threading.Event()
        self._status = screen.status("meshing")
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def tell(self, said: str) -> None:
        """Say what is meshed."""
        self._said = said
        self._status.update(Text(f"meshing: {said}"))  # names in it are no markup

    def __enter__(self) -> Meshing:
        """Start."""
        self._status.start()
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """End."""
        self._ended.set()
        self._status.stop()
        self._thread.join()

    def _watch(self) -> None:
        start = time.monotonic()
        while True:
            left = self._limit_s - (time.monotonic() - start)
            if self._ended.wait(min(EVERY_S, max(left, 0.0))):
                return
            passed = time.monotonic() - start
            if passed >= self._limit_s:
                break
            if not self._screen.is_terminal:
                self._screen.print(f"meshing, {passed:.0f} s: {self._said}", soft_wrap=True)
        self._status.stop()
        sys.stdout.flush()
        sys.stderr.write(
            f"dolfingrip: {self._part}: no mesh after {self._limit_s:g} s: {self._said}; allowed: "
            "another --size-mm, a longer --limit-s, or thicker walls\n"
        )
        sys.stderr.flush()
        os._exit(2)
