"""How the command ends: its exit code, and the line that says why."""

from __future__ import annotations

import sys
import traceback
from pathlib import Path
from typing import Any, NoReturn, TextIO

INTERRUPTED = 130
"""Exit code after Ctrl-C, as of shells."""


def end(ending: Exception | SystemExit, errors: TextIO) -> NoReturn:
    """End the command on all ranks.

    Args:
        ending: what the command raised.
        errors: this rank's own standard error, for errors that may be on this rank alone.

    Raises:
        SystemExit: with the exit code.
        Exception: ``ending`` itself, on one rank, where it is an error of the program.
    """
    if isinstance(ending, SystemExit):
        if ending.code == INTERRUPTED:
            _say_interrupted(ending)
        _exit(ending.code)
    if isinstance(ending, ModuleNotFoundError) and ending.name:
        from dolfingrip.cli.installation import how_to_install

        if said := how_to_install(ending.name.partition(".")[0]):
            _say(said)
            _exit(1)
    from dolfingrip.files.result_file import ResultFileError
    from dolfingrip.files.whole import FULL, WriteError, failed
    from dolfingrip.jobs.interrupts import interrupt_behind
    from dolfingrip.sections.errors import ConfigError, MachineError

    if isinstance(ending, ConfigError | ResultFileError):  # the same on all ranks
        _say(ending)
        _exit(2)
    if isinstance(ending, MachineError):
        _say(ending)
        if _size() > 1:  # it may be on this rank alone
            _world().Abort(1)
        _exit(1)
    if isinstance(ending, WriteError):  # on all ranks, too
        _say(ending)
        _exit(1)
    if interrupt_behind(ending):
        _say_interrupted(ending)
        _exit(INTERRUPTED)
    if _size() == 1:
        if isinstance(ending, OSError) and ending.errno in FULL and ending.filename:
            _say(failed(Path(ending.filename), ending))
            _exit(1)
        raise ending
    # without this the other ranks would wait for this one for ever
    traceback.print_exception(ending, file=errors)
    errors.flush()
    _world().Abort(70)
    raise ending


def _world() -> Any:
    """The ranks, once MPI is loaded; a command that needs none loads none."""
    return sys.modules["mpi4py.MPI"].COMM_WORLD


def _size() -> int:
    return _world().size if "mpi4py.MPI" in sys.modules else 1


def _exit(code: object) -> NoReturn:
    """Exit on all ranks after rank 0 has printed; mpirun kills all ranks as soon as one fails."""
    sys.stdout.flush()
    sys.stderr.flush()
    if code and code != INTERRUPTED and _size() > 1:  # an interrupt may be on this rank alone
        _world().Barrier()
    sys.exit(code)  # type: ignore[arg-type]


def _say(what: object) -> None:
    sys.stderr.write(f"dolfingrip: {what}\n")
    sys.stderr.flush()


def _say_interrupted(error: BaseException) -> None:
    """Say in one line what an interrupted command kept, and how to go on."""
    from dolfingrip.jobs.interrupts import interrupt_behind

    said = interrupt_behind(error)
    sentence = str(said) if said and said.args else "the same command starts from the beginning"
    _say(f"interrupted: {sentence}")
