"""A closed output pipe, as in ``dolfingrip mesh | head``, loses no results."""

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
        stream: the stream behind it. It has a file descriptor.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write to the stream; its length is returned where the reader has gone, too."""
        try:
            return self._stream.write(text)
        except BrokenPipeError:
            self._drop()
            return len(text)

    def flush(self) -> None:
        """Flush what is buffered."""
        try:
            self._stream.flush()
        except BrokenPipeError:
            self._drop()

    def _drop(self) -> None:
        """Point the descriptor at the null device, where the rest of the buffer can go."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)


@contextmanager
def unbroken_output() -> Iterator[None]:
    """A context in which a closed output pipe does not end the command.

    Python has no stream at all where the shell closed it (``>&-``). Text is dropped then, too.
    """
    before = sys.stdout, sys.stderr
    # PETSc, loaded later, answers the signal by ending all ranks: it must never arrive
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
