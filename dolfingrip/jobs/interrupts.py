"""Ctrl-C: a temporary handler, and what is kept; connections that break are errors."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, with a sentence that says what is kept and how to go on."""


def interrupt_behind(error: BaseException | None) -> KeyboardInterrupt | None:
    """The interrupt behind an error, the first with a sentence where there is one.

    PETSc passes an interrupt of a callback on as an error of its own.

    Args:
        error: the error with its causes.

    Returns:
        The interrupt; None if there is none.
    """
    interrupts: list[KeyboardInterrupt] = []
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            interrupts.append(error)
        error = error.__cause__ or error.__context__
    told = [each for each in interrupts if isinstance(each, Interrupted)]
    return next(iter([*told, *interrupts]), None)


@contextmanager
def interrupts_answered_by(handler: Callable[[int, Any], None] | signal.Handlers) -> Iterator[None]:
    """Let the handler answer SIGINT, which only the main thread gets."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def broken_connections_are_errors() -> Iterator[None]:
    """Block SIGPIPE in this thread, and in threads and processes that it starts.

    PETSc takes the signal for a crash and ends the process, and TLS writes to a connection as it
    is closed. Without the signal the write raises BrokenPipeError.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
    try:
        yield
    finally:
        if signal.SIGPIPE not in before:
            signal.sigtimedwait({signal.SIGPIPE}, 0)  # discards one that waits
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
