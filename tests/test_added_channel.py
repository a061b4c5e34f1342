"""A channel is added as the docs say: a reading in its file, and one entry. All else follows."""

from __future__ import annotations

import filecmp
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import dolfingrip
import dolfingrip.forms
import dolfingrip.meshes

HERE = Path(__file__).parent / "added_channel"


def differing(left: Path, right: Path) -> set[str]:
    """Files that are not the same, or in one of two folders alone, by their path below it."""
    files = {
        file.relative_to(top)
        for top in (left, right)
        for file in top.rglob("*.py")
        if file.relative_to(top).parts[0] not in ("forms", "meshes")
    }
    _, changed, alone = filecmp.cmpfiles(left, right, map(str, files), shallow=False)
    return {*changed, *alone}


@pytest.mark.slow
def test_a_channel_is_a_file_and_an_entry(tmp_path: Path) -> None:
    """In a copy of the package: through an experiment, files, noise, table, plot and diagnosis."""
    package = Path(dolfingrip.__file__).parent
    copy = tmp_path / "dolfingrip"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("forms", "meshes"))
    for part in (dolfingrip.forms, dolfingrip.meshes):  # installed within the package or next to it
        folder = Path(next(iter(part.__path__)))
        (copy / part.__name__.rpartition(".")[2]).symlink_to(folder, target_is_directory=True)
    shutil.copy(HERE / "narrowing.py", copy / "mechanics" / "readings")
    channels = copy / "channels.py"
    text = channels.read_text(encoding="utf-8")
    entry = (HERE / "entry.txt").read_text(encoding="utf-8")
    end = "\nCHANNELS: Final"
    assert text.count(end) == 1
    channels.write_text(text.replace(end, f"{entry}{end}"), encoding="utf-8")
    assert differing(package, copy) == {"channels.py", "mechanics/readings/narrowing.py"}

    paths = os.pathsep.join([str(tmp_path), str(HERE.parent)])
    done = subprocess.run(
        [sys.executable, "-P", str(HERE / "flow.py"), str(tmp_path / "out")],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    print(done.stdout, done.stderr)
    assert done.returncode == 0
