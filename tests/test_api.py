"""The Python lines that the README shows do what it says."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import pytest

README = Path(__file__).resolve().parents[1] / "README.md"


def _lines() -> str:
    """The first block of Python in the README."""
    found = re.search(r"^```python\n(.*?)^```$", README.read_text(encoding="utf-8"), re.M | re.S)
    assert found is not None
    return found[1]


def test_the_readmes_lines_are_ten_at_most() -> None:
    assert len([line for line in _lines().splitlines() if line.strip()]) <= 10


def test_the_readmes_lines_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(compile(_lines(), str(README), "exec"), names)
    said = capsys.readouterr().out
    angles = [float(angle) for angle in re.findall(r"kPa: (-?[\d.]+) deg", said)]
    # 0 to 100 kPa in steps of 25, each bending the finger further
    assert len(angles) == 5
    assert angles[0] == 0.0
    assert all(b > a + 5 for a, b in itertools.pairwise(angles))
    force = re.search(r"blocked force ([\d.]+) N", said)
    assert force is not None
    assert 0.5 < float(force[1]) < 2.0
    (folder,) = {file.parent for file in tmp_path.rglob("result.csv")}
    assert {"result.csv", "run.json", "fields.pvd"} <= {file.name for file in folder.iterdir()}
