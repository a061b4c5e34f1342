"""A reading of one's own is one file, with its column. All else follows."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from dolfingrip.plugins import VARIABLE

HERE = Path(__file__).parent / "added_channel"


@pytest.mark.slow
def test_a_channel_is_one_file(tmp_path: Path) -> None:
    """Through an experiment, files, noise, table, plot and diagnosis."""
    done = subprocess.run(
        [sys.executable, "-P", str(HERE / "flow.py"), str(tmp_path)],
        env={**os.environ, "PYTHONPATH": str(HERE.parent), VARIABLE: str(HERE / "narrowing.py")},
        capture_output=True,
        text=True,
        check=False,
    )
    print(done.stdout, done.stderr)
    assert done.returncode == 0
