"""Keeps results where the output pipe is closed early, as in ``dolfingrip mesh | head``."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast


class Unbroken:
    """A text stream that stays usable once its reader has closed the pipe.

    What is written after the reader has gone is dropped. The command does its work to the end and
    keeps its own exit code.

    Args:
        stream: stream that is written to; it has a file descriptor.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write to the stream; return the text's length, also if the reader has gone."""
        try:
            return self._stream.write(text)
        except BrokenPipeError:
            self._drop()
            return len(text)

    def flush(self) -> None:
        """Flush the buffer."""
        try:
            self._stream.flush()
        except BrokenPipeError:
            self._drop()

    def _drop(self) -> None:
        """Point the descriptor at the null device, so that the rest of the buffer goes there."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)


@contextmanager
def unbroken_output() -> Iterator[None]:
    """A context in which a closed output pipe does not end the command.

    Python has no stream at all where the shell closed it (``>&-``). Text is dropped then, too.
    """
    before = sys.stdout, sys.stderr
    # PETSc, which is loaded later, ends all ranks on this signal, so it must never arrive
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
    with open(os.devnull, "w", encoding="utf-8") as nowhere:
        sys.stdout, sys.stderr = (
            nowhere if stream is None else cast(TextIO, Unbroken(stream)) for stream in before
        )
        try:
            yield
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            sys.stdout, sys.stderr = before
            signal.signal(signal.SIGPIPE, signal.SIG_IGN)  # discards one that waits
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
