"""The command ``dolfingrip``, run in the process of the test."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from dolfingrip.cli import app, edge
from dolfingrip.cli.installation import how_to_install


def run_command(*arguments: str | Path) -> int:
    """Run ``dolfingrip`` with these arguments, and return its exit code.

    Raises:
        ModuleNotFoundError: a package that the command said how to install.
    """
    absent = []

    def said(module: str) -> str:
        absent.append(module)
        return how_to_install(module)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["dolfingrip", *map(str, arguments)])
        patch.setattr(edge, "how_to_install", said)
        with pytest.raises(SystemExit) as ended:
            app.main()
    if absent:
        raise ModuleNotFoundError(name=absent[0])
    return int(ended.value.code or 0)
