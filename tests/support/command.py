"""The command ``dolfingrip``, run in the process of the test."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from dolfingrip.cli import app, edge
from dolfingrip.cli.installation import how_to_install


@contextmanager
def in_this_process() -> Iterator[None]:
    """Put back how SIGTERM is answered, which a command ignores from its end to its process' end.

    Processes that later tests start would ignore it, too, and be waited for until they are killed.
    """
    before = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before or signal.SIG_DFL)


def run_command(*arguments: str | Path) -> int:
    """Run ``dolfingrip`` with these arguments, and return its exit code.

    Raises:
        ModuleNotFoundError: a package that the command said how to install.
    """
    absent = []

    def said(module: str) -> str:
        absent.append(module)
        return how_to_install(module)

    with pytest.MonkeyPatch.context() as patch, in_this_process():
        patch.setattr(sys, "argv", ["dolfingrip", *map(str, arguments)])
        patch.setattr(edge, "how_to_install", said)
        with pytest.raises(SystemExit) as ended:
            app.main()
    if absent:
        raise ModuleNotFoundError(name=absent[0])
    return int(ended.value.code or 0)
