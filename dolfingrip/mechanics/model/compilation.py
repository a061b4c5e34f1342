"""Compiled code in the cache: made by one process at a time, whole or not at all.

A form, or the binding of a library, has a folder of its own. A process that holds a lock of the
operating system compiles it in a folder beside that, and renames this at the end. The system
releases the lock however the process ends, and the next process that needs the form compiles it
anew. A folder that has its name is whole.
"""

from __future__ import annotations

import fcntl
import os
import shutil
import socket
import sys
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Final, TextIO

import cffi
from mpi4py import MPI

from dolfingrip.sections.errors import MachineError

Tell = Callable[[str], None]
"""Receives one line about what goes on; an empty line ends it."""

_IN_PROCESS = threading.Lock()
"""A compile changes the process' working folder and its standard output."""


SILENT_S: Final = 2.0
"""Time after which a compile, or a wait, tells that it goes on."""

EVERY_S: Final = 1.0
"""Time from one such message to the next."""

POLL_S: Final = 0.05
"""Time between two attempts to get the lock."""

PATIENCE_S: Final = 600.0
"""Longest wait for a process that compiles the same; it may be suspended."""


class CompilationError(MachineError):
    """Code that could not be compiled here and now: no compiler, a full disk, another process."""


_listener: ContextVar[Tell | None] = ContextVar("listener", default=None)
_next_line_s = 0.0


def _lines(line: str, pause_s: float = 30.0) -> None:
    """Tell on the standard error of one rank, a line each ``pause_s`` seconds at most."""
    global _next_line_s
    now_s = time.monotonic()
    if line and now_s >= _next_line_s and MPI.COMM_WORLD.rank == 0:
        _next_line_s = now_s + pause_s
        # in place of a bar that the process of a campaign draws on the same terminal
        begin = "\r\x1b[K" if sys.stderr.isatty() else ""
        sys.stderr.write(f"{begin}dolfingrip: {line}\n")
        sys.stderr.flush()


@contextmanager
def told_to(tell: Tell | None) -> Iterator[None]:
    """Send what compiles tell in this block to a listener.

    Args:
        tell: called from another thread with a line each second, once a compile, or the wait for
            another process that compiles the same, takes more than two seconds. None: as outside
            of this block; first of all, lines on the standard error.
    """
    token = _listener.set(tell or _listener.get())
    try:
        yield
    finally:
        _listener.reset(token)


def compiled[T](folder: Path, get: Callable[[Path], T], what: str) -> T:
    """Load what a folder of the cache holds, after compiling it where it is missing or broken.

    Args:
        folder: of this code alone. Its name contains all that the code depends on.
        get: loads the code from a folder, after compiling it there if the folder is empty.
        what: is compiled, in words.

    Returns:
        What ``get`` returns.

    Raises:
        CompilationError: the compiler failed, or another process held the lock for too long.
    """
    # a folder may have lost files, by a power cut or by hand: then nothing can be loaded from it
    with suppress(Exception):
        if folder.exists():
            with suppress(OSError):
                os.utime(folder)  # scripts/run --forget removes what has not been used for long
            return get(folder)
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with _locked(folder.with_name(f"{folder.name}.lock"), what) as alone:
            with suppress(Exception):
                if folder.exists():  # another process has compiled it meanwhile
                    return get(folder)
            shutil.rmtree(folder, ignore_errors=True)
            if alone:
                for left in folder.parent.glob(f"{folder.name}.*.part"):
                    shutil.rmtree(left, ignore_errors=True)
            return _made(folder, get, what)
    except (OSError, ImportError, cffi.VerificationError) as error:
        raise CompilationError(f"{what} could not be compiled: {error}") from error


def _made[T](folder: Path, get: Callable[[Path], T], what: str) -> T:
    """Compile into a new folder; an error or an interrupt leaves nothing of it."""
    place = folder.with_name(f"{folder.name}.{uuid.uuid4().hex[:8]}.part")
    place.mkdir()
    try:
        with _watched(lambda: f"compiling {what}"), _IN_PROCESS, _listed_once():
            made = get(place)
        try:
            place.rename(folder)
        except OSError:
            if not folder.exists():  # on a disk without locks another process may have been first
                raise
        return made
    finally:
        shutil.rmtree(place, ignore_errors=True)


_entry_points = cache(metadata.entry_points)


@contextmanager
def _listed_once() -> Iterator[None]:
    """Let setuptools, by which CFFI calls the compiler, list entry points once a process.

    It reads those of all packages six times for each form, which takes a second.
    """
    entry_points = metadata.entry_points
    metadata.entry_points = lambda **selected: _entry_points().select(**selected)
    try:
        yield
    finally:
        metadata.entry_points = entry_points


@contextmanager
def _locked(path: Path, what: str) -> Iterator[bool]:
    """Hold a lock of the operating system; yield False on a disk that has none."""
    while True:
        with path.open("a+", encoding="utf-8", errors="replace") as file:
            alone = _acquired(file, what)
            if alone and not _is_at(path, file):  # its last holder has removed it
                continue
            file.truncate(0)
            file.write(f" on {socket.gethostname()}")
            file.flush()
            try:
                yield alone
            finally:
                path.unlink(missing_ok=True)
            return


def _is_at(path: Path, file: TextIO) -> bool:
    try:
        return os.path.samefile(file.fileno(), path)
    except OSError:
        return False


def _acquired(file: TextIO, what: str) -> bool:
    """Wait for the lock of a file; return False on a disk that has none."""
    began_s = time.monotonic()

    def wait() -> str:
        file.seek(0)
        return f"waiting for another process{file.read()[:80]}, which compiles {what}"

    with _watched(wait):
        while True:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return True
            except BlockingIOError:
                if time.monotonic() - began_s > PATIENCE_S:
                    raise CompilationError(f"{wait()}, given up after {PATIENCE_S:.0f} s") from None
            except OSError:
                return False
            time.sleep(POLL_S)


@contextmanager
def _watched(line: Callable[[], str]) -> Iterator[None]:
    """Tell what goes on in this block, and for how long, once it has taken some time."""
    tell, began_s, over = _listener.get() or _lines, time.monotonic(), threading.Event()

    def watch() -> None:
        pause_s, reported = SILENT_S, False
        while not over.wait(pause_s):
            tell(f"{line()}, {time.monotonic() - began_s:.0f} s")
            pause_s, reported = EVERY_S, True
        if reported:
            tell("")

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
