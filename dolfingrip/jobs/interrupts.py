"""Ctrl-C and SIGTERM: a temporary handler, and what is kept."""

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
    with_sentence = [interrupt for interrupt in interrupts if isinstance(interrupt, Interrupted)]
    return next(iter([*with_sentence, *interrupts]), None)


class Termination:
    """Answers SIGTERM as Ctrl-C is answered.

    Attributes:
        came: whether the signal came.
    """

    came = False

    def __call__(self, number: int, frame: Any) -> None:
        """Answer the signal."""
        self.came = True
        answer = signal.getsignal(signal.SIGINT)
        if not callable(answer):  # a shell's background job ignores Ctrl-C
            raise KeyboardInterrupt
        answer(signal.SIGINT, frame)


@contextmanager
def interrupts_answered_by(handler: Callable[[int, Any], None] | signal.Handlers) -> Iterator[None]:
    """Let the handler answer SIGINT, which only the main thread gets.

    Args:
        handler: called with the signal's number and the frame, or one of signal's own.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
