"""The spool: finished answers on disk before they are sent.

A worker writes its answer here before it returns it, so that an answer outlives both the worker
and the client. A lock on each job, which the system releases however its holder ends, keeps
two workers from computing the same one. Local disks and network disks with flock will do.
"""

from __future__ import annotations

import fcntl
import logging
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from dolfingrip.files import whole
from dolfingrip.jobs.job import JobResult

_LOG = logging.getLogger(__name__)


class Spool:
    """A folder of answers, ``KEY.json`` each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def read(self, key: str) -> JobResult | None:
        """The answer of a job, None where there is none; a damaged one is set aside."""
        file = self.folder / f"{key}.json"
        try:
            answer = JobResult.loads(file.read_text(encoding="utf-8"))
            if answer.key == key:
                return answer
            why = "the answer of another job"
        except FileNotFoundError:
            return None
        except (IsADirectoryError, ValueError) as error:
            why = str(error)
        aside = file.with_name(f"{file.name}.damaged")
        _LOG.warning("%s: damaged: %s; set aside as %s, to be computed anew", file, why, aside.name)
        with suppress(OSError):  # where it may not be written, or another process was faster
            file.rename(aside)
        return None

    def write(self, answer: JobResult) -> None:
        """Keep an answer: all of it or, where the process is killed, nothing."""
        whole.write(self.folder / f"{answer.key}.json", answer.dumps())

    def answers(self) -> Iterator[JobResult]:
        """All that were spooled."""
        for path in sorted(self.folder.glob("[!.]*.json")):  # others are being written
            answer = self.read(path.stem)
            if answer is not None:
                yield answer

    @contextmanager
    def claimed(self, key: str) -> Iterator[None]:
        """Hold a job alone: others that claim it wait."""
        with (self.folder / f"{key}.lock").open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield

    def forget(self, key: str) -> None:
        """Drop a job's answer."""
        (self.folder / f"{key}.json").unlink(missing_ok=True)

    def clear(self) -> None:
        """Drop everything, once all of it is stored and no worker is left."""
        for path in self.folder.glob("*.*"):
            if path.suffix in (".json", ".lock"):
                path.unlink(missing_ok=True)
