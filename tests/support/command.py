"""The command ``dolfingrip``, run in the process of the test."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from dolfingrip.cli import app


def run_command(*arguments: str | Path) -> int:
    """Run ``dolfingrip`` with these arguments, and return its exit code."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["dolfingrip", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            app.main()
    return int(ended.value.code or 0)
