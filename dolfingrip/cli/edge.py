"""The edge of the command: whatever happens inside becomes an exit code and at most one line."""

from __future__ import annotations

import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import Any, NoReturn, TextIO, cast

import typer

from dolfingrip.cli.installation import how_to_install
from dolfingrip.files.result_file import ResultFileError
from dolfingrip.files.whole import FULL, WriteError, failed, write
from dolfingrip.jobs.interrupts import Termination, interrupt_behind, interrupts_answered_by
from dolfingrip.plugins import PluginError
from dolfingrip.sections.errors import ConfigError, MachineError, printable
from dolfingrip.sections.private import cache_folder

INTERRUPTED = 130
"""Exit code after Ctrl-C, as of shells."""

TERMINATED = 143
"""Exit code after SIGTERM, as of shells."""

BROKEN = 70
"""Exit code where dolfingrip itself failed, EX_SOFTWARE of ``sysexits.h``."""

QUIET = " -no_signal_handler"
"""Option of PETSc that leaves signals to Python, and to what ends workers."""

LAUNCHED = ("PMIX_RANK", "OMPI_COMM_WORLD_RANK", "PMI_RANK")
"""Variables that mpirun sets for its processes."""


class Unbroken:
    """A text stream that stays usable once what is written to it goes nowhere.

    What is written after its reader has closed the pipe, or to a full disk, is dropped. The command
    does its work to the end.

    Args:
        stream: stream that is written to; it has a file descriptor.

    Attributes:
        lost: why something was dropped; None where nothing was, or where the reader had enough.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.lost: OSError | None = None
        if isinstance(stream, TextIOWrapper):  # a character that it cannot have is spelled
            stream.reconfigure(errors="backslashreplace")

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write to the stream; return the text's length, also if it is dropped."""
        try:
            return self._stream.write(text)
        except OSError as error:
            self._drop(error)
            return len(text)

    def flush(self) -> None:
        """Flush the buffer."""
        try:
            self._stream.flush()
        except OSError as error:
            self._drop(error)

    def _drop(self, error: OSError) -> None:
        """Point the descriptor at the null device, so that the rest of the buffer goes there."""
        if not isinstance(error, BrokenPipeError):
            self.lost = error
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


def _world() -> Any:
    """All ranks; None where mpirun did not start this process, which then loads no MPI."""
    if not any(name in os.environ for name in LAUNCHED):
        return None
    from mpi4py import MPI

    return MPI.COMM_WORLD


def rank() -> int:
    """Return the rank of this process."""
    world = _world()
    return 0 if world is None else int(world.rank)


def run(make: Callable[[], Any]) -> NoReturn:
    """Run the command with the arguments of the process, and exit.

    The exit code is 0 after success, 1 if a load path ended early (the results up to there are
    kept, and a sentence says why it ended), the machine failed, or a file could not be written (one
    line says which and why, and what was there before is untouched), 2 after bad input, which one
    line names, 70 if dolfingrip itself failed (one line says where the traceback is), 130 after
    Ctrl-C, and 143 after SIGTERM. A closed output pipe does not change it.

    Args:
        make: returns the command of the command line.
    """
    os.environ.setdefault("HOME", os.path.expanduser("~"))  # without it Open MPI ends the process
    # workers would import a stranger's signal.py from the working folder; this process does not
    os.environ["PYTHONSAFEPATH"] = "1"
    # PETSc, once it is loaded, would answer SIGTERM by seven lines
    options = os.environ.get("PETSC_OPTIONS", "").replace(QUIET, "")
    os.environ["PETSC_OPTIONS"] = options + QUIET
    termination = Termination()
    signal.signal(signal.SIGTERM, termination)
    with unbroken_output(), ExitStack() as stack:
        world, errors = _world(), sys.stderr
        if rank():  # rank 0 alone prints errors that all ranks have
            sys.stdout = sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
        code, line, everywhere = _result(make)
        # the command is over: a signal that comes now would only interrupt what says how it ended
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        stack.enter_context(interrupts_answered_by(signal.SIG_IGN))
        if code == INTERRUPTED and termination.came:
            code, line = TERMINATED, line.replace("interrupted", "terminated", 1)
        sys.stdout.flush()
        lost = getattr(sys.stdout, "lost", None)
        if lost is not None and not code:
            code, line = 1, str(failed(Path("standard output"), lost))
        if not everywhere and world is not None and world.size > 1:
            # without this the other ranks would wait for this one for ever
            _say(line, errors)
            world.Abort(code)
        _say(line, sys.stderr)
        _end(code, world)


def _result(make: Callable[[], Any]) -> tuple[int, str, bool]:
    """Exit code, the line that says why, and whether it is the same on all ranks."""
    try:
        command = make()
        with command.make_context("dolfingrip", sys.argv[1:]) as context:
            command.invoke(context)
    except typer.Exit as ending:
        return ending.exit_code, "", True
    except (ConfigError, PluginError, ResultFileError) as error:
        return 2, str(error), True
    except WriteError as error:
        return 1, str(error), True
    except MachineError as error:
        return 1, str(error), False
    except (Exception, KeyboardInterrupt) as error:
        if (behind := interrupt_behind(error)) is not None:
            sentence = str(behind) if behind.args else "the same command starts from the beginning"
            return INTERRUPTED, f"interrupted: {sentence}", True
        if isinstance(error, typer.TyperException):
            return error.exit_code, _usage(error), True
        if isinstance(error, ModuleNotFoundError) and (wanted := how_to_install(error.name or "")):
            sys.stderr.write(f"dolfingrip: {wanted}\n")  # lines to copy
            return 1, "", True
        if isinstance(error, OSError) and error.errno in FULL:
            return 1, str(failed(Path(str(error.filename or "a file")), error)), False
        return BROKEN, _unexpected(error), False
    return 0, "", True


def _usage(error: typer.TyperException) -> str:
    """One line about a command line that has no such form."""
    context = getattr(error, "ctx", None)
    path = "dolfingrip" if context is None else context.command_path
    said = " ".join(error.format_message().split()).rstrip(".")
    if not said:  # the help is printed already
        return ""
    return f"{said}; allowed: see {path} --help"


def _unexpected(error: BaseException) -> str:
    """One line about a failure of dolfingrip itself, whose traceback goes into a file."""
    what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    text = "".join(traceback.format_exception(error))
    name = f"{time.strftime('%Y-%m-%dT%H-%M-%S')}-{os.getpid()}.log"
    try:
        file = cache_folder("dolfingrip", "errors") / name
        write(file, f"{sys.argv}\n{text}".encode(errors="backslashreplace"))
    except (OSError, ConfigError):
        return f"{what}; this is a fault of dolfingrip, and its traceback cannot be written"
    return f"{what}; this is a fault of dolfingrip: report it with its traceback, {file}"


def _say(line: str, stream: TextIO) -> None:
    if line:
        stream.write(f"dolfingrip: {printable(line)}\n")
        stream.flush()


def _end(code: int, world: Any) -> NoReturn:
    """Exit on all ranks after rank 0 has printed; mpirun kills all ranks as soon as one fails."""
    sys.stdout.flush()
    sys.stderr.flush()
    signalled = code in (INTERRUPTED, TERMINATED)  # which may be this rank's alone
    if code and not signalled and world is not None:
        world.Barrier()
    sys.exit(code)
