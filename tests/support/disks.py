"""Folders on a disk that can be full.

Root gets a disk in memory of its own; others get a limit of the size of each file, which the
system's errors come from as well.
"""

from __future__ import annotations

import os
import resource
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SIZE = 32 << 20
"""Bytes of a disk in memory."""


class Disk:
    """A folder whose disk can be filled.

    Attributes:
        folder: the folder.
        reason: what the system says where the disk is full.
    """

    reason = "File too large"

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @contextmanager
    def full(self, left: int = 0) -> Iterator[None]:
        """A context in which no more than ``left`` bytes can be written (into each file)."""
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (left, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    def contents(self) -> dict[str, bytes]:
        """All files by their names, hidden ones included."""
        return {
            str(path.relative_to(self.folder)): path.read_bytes()
            for path in sorted(self.folder.rglob("*")) if path.is_file()
        }  # fmt: skip


class MemoryDisk(Disk):
    """A disk of its own, in memory."""

    reason = "No space left on device"

    @contextmanager
    def full(self, left: int = 0) -> Iterator[None]:
        """A context in which no more than ``left`` bytes can be written, in whole pages."""
        filler = self.folder / "filler"
        free = os.statvfs(self.folder)
        with filler.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, max(free.f_bavail * free.f_frsize - left, 1))
        try:
            yield
        finally:
            filler.unlink()


@contextmanager
def mounted(folder: Path) -> Iterator[bool]:
    """Mount a disk in memory, where that is allowed; whether it is."""
    command = ["mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", str(folder)]
    try:
        done = subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        done = False
    try:
        yield done
    finally:
        if done:
            subprocess.run(["umount", "--lazy", str(folder)], check=True)
