"""One worker for one job: the newest wins, answers are kept, a lost worker is answered for."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest
from support import waiting

from dolfingrip.jobs.job import Job, JobResult
from dolfingrip.jobs.single import Single

LIMIT_S = 60.0


class Heard:
    """What a worker said."""

    def __init__(self) -> None:
        self.answers: SimpleQueue[JobResult] = SimpleQueue()
        self.progress: SimpleQueue[tuple[Any, ...]] = SimpleQueue()

    def tell(self, *progress: Any) -> None:
        self.progress.put(progress)


@pytest.fixture
def heard() -> Heard:
    return Heard()


@pytest.fixture
def single(tmp_path: Path, heard: Heard) -> Iterator[Single]:
    found = Single(tmp_path / "spool", heard.tell, heard.answers.put)
    yield found
    found.close()


def job(tmp_path: Path, name: str, seconds: float) -> Job:
    arguments = {"start": str(tmp_path / f"{name}.pid"), "seconds": seconds}
    return Job(name, waiting.PATH, arguments)


def begun(file: Path) -> int:
    """Process of a job, once it runs."""
    limit = time.monotonic() + LIMIT_S
    while not (file.is_file() and file.read_text()):
        assert time.monotonic() < limit
        time.sleep(0.02)
    return int(file.read_text())


def test_the_newest_wins_and_its_answer_is_kept(
    tmp_path: Path, single: Single, heard: Heard
) -> None:
    single.ask(job(tmp_path, "old", 600))
    old = begun(tmp_path / "old.pid")
    assert heard.progress.get(timeout=LIMIT_S) == ("old", 1, 2, "waiting")
    single.ask(job(tmp_path, "new", 0))
    answer = heard.answers.get(timeout=LIMIT_S)
    assert (answer.key, answer.status, answer.result) == ("new", "done", {"waited_s": 0})
    assert heard.progress.get(timeout=LIMIT_S) == ("new", 1, 2, "waiting")
    with pytest.raises(ProcessLookupError):
        os.kill(old, 0)
    assert single.job is None
    assert single.known("old") is None
    kept = Single(tmp_path / "spool", heard.tell, heard.answers.put).known("new")
    assert kept is not None
    assert kept.result == {"waited_s": 0}


def test_a_job_that_tells_its_progress_leaves_the_worker_to_the_next(
    tmp_path: Path, single: Single, heard: Heard
) -> None:
    single.begin()
    told = {"start": str(tmp_path / "told.pid"), "seconds": 600, "every_s": 0.02}
    single.ask(Job("told", waiting.PATH, told))
    worker = begun(tmp_path / "told.pid")
    single.ask(job(tmp_path, "next", 0))
    assert heard.answers.get(timeout=LIMIT_S).key == "next"
    assert begun(tmp_path / "next.pid") == worker
    assert single.known("told") is None


def test_a_worker_that_dies_is_answered_for(tmp_path: Path, single: Single, heard: Heard) -> None:
    single.ask(job(tmp_path, "lost", 600))
    os.kill(begun(tmp_path / "lost.pid"), signal.SIGKILL)
    answer = heard.answers.get(timeout=LIMIT_S)
    assert (answer.key, answer.status) == ("lost", "broken")
    single.ask(job(tmp_path, "next", 0))  # another worker takes its place
    assert heard.answers.get(timeout=LIMIT_S).status == "done"


def test_a_job_that_is_cancelled_has_no_answer(
    tmp_path: Path, single: Single, heard: Heard
) -> None:
    single.ask(job(tmp_path, "cancelled", 600))
    begun(tmp_path / "cancelled.pid")
    single.cancel()
    assert single.job is None
    assert heard.answers.empty()
