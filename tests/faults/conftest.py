"""Disks that tests fill."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from support.disks import Disk, MemoryDisk, mounted


@pytest.fixture(params=["memory", "limit"])
def each_disk(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Disk]:
    """A folder on either kind of disk."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if request.param == "limit":
        yield Disk(folder)
        return
    with mounted(folder) as done:
        if not done:
            pytest.skip("no disk can be mounted")
        yield MemoryDisk(folder)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Disk]:
    """A folder on a disk of its own where one can be mounted."""
    folder = tmp_path / "disk"
    folder.mkdir()
    with mounted(folder) as done:
        yield MemoryDisk(folder) if done else Disk(folder)
