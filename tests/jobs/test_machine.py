"""What the machine does is no result of the model: it is tried again, told, and never stored."""

from __future__ import annotations

import errno
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
from support.small import short
from support.this_process import ThisProcess
from typer.testing import CliRunner

from dolfingrip.cli.commands import app
from dolfingrip.config import Config
from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.quantities.quantity import Outcome
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.simulate import job as requested
from dolfingrip.jobs import pool as pools
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.job import MACHINE, Data, Job, JobResult
from dolfingrip.jobs.pool import Unfinished
from dolfingrip.jobs.run import Standing, run
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.store import Store, same
from dolfingrip.jobs.work import compute, of_machine, work

SHARED = same(kind="test")


@pytest.fixture(autouse=True)
def pauses(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Pauses between attempts (s), which nobody waits for."""
    found: list[float] = []
    clock = SimpleNamespace(perf_counter=time.perf_counter, sleep=found.append)
    monkeypatch.setattr("dolfingrip.jobs.work.time", clock)
    return found


def job(key: str, folder: Path, times: int, error: str = "timeout") -> Job:
    return Job(key, f"{__name__}:breaks", {"folder": str(folder), "times": times, "error": error})


def breaks(folder: str, times: int, error: str) -> Data:
    """Breaks off some times, then finds how often it was called."""
    file = Path(folder) / f"{error}.calls"
    called = int(file.read_text()) + 1 if file.exists() else 1
    file.write_text(str(called))
    if called > times:
        return {"calls": called}
    if error == "timeout":  # as FFCx says it, behind an error of the form
        try:
            raise TimeoutError("JIT compilation timed out")
        except TimeoutError as behind:
            raise RuntimeError("no form") from behind
    raise {"memory": MemoryError(), "disk": OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))}[error]


def test_a_job_that_the_machine_broke_off_is_tried_again(
    tmp_path: Path, pauses: list[float]
) -> None:
    told: list[tuple[int, int]] = []

    def progress(standing: Standing) -> None:
        told.append((standing.done, standing.again))

    jobs = [job("a", tmp_path, 2)]
    standing = run(jobs, tmp_path / "jobs", ThisProcess(), SHARED, progress=progress)
    assert (standing.done, standing.failed, standing.broken) == (1, 0, 0)
    assert told == [(0, 0), (1, 2)]
    assert pauses == [1, 2]
    with Store(tmp_path / "jobs") as store:
        (row,) = store.rows()
    assert row["result"] == {"calls": 3}


@pytest.mark.parametrize("error", ["memory", "disk"])
def test_what_stays_broken_is_told_and_not_stored(tmp_path: Path, error: str) -> None:
    """The other jobs are done, and the next call computes this one."""
    folder, jobs = tmp_path / "jobs", [job("a", tmp_path, 3, error), job("b", tmp_path, 0)]
    said = "ran out of memory" if error == "memory" else "No space left on device"
    with pytest.raises(Unfinished, match=rf"^1 of 2 could not be computed .*{said}") as ended:
        run(jobs, folder, ThisProcess(), SHARED)
    assert "\n" not in str(ended.value)
    with Store(folder) as store:
        assert {row["key"]: row["status"] for row in store.rows()} == {"a": "pending", "b": "done"}
    standing = run(jobs, folder, ThisProcess(), SHARED)
    assert (standing.computed, standing.done, standing.failed) == (1, 2, 0)


def test_a_spool_on_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(spool: Spool, answer: JobResult) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Spool, "write", full)
    answer = work(job("a", tmp_path, 0), tmp_path)
    assert (answer.status, answer.failure_class, answer.result) == ("broken", MACHINE, None)
    assert len(answer.broken) == 2


def test_what_is_of_the_machine() -> None:
    class OfPETSc(RuntimeError):
        ierr = 55  # out of memory, as petscsystypes.h numbers it

    assert of_machine(OfPETSc())
    assert not of_machine(ZeroDivisionError())


@pytest.mark.parametrize(
    ("said", "code", "failure"),
    [
        (
            "prterun noticed that process rank 1 with PID 7 on vm exited on\nsignal 9 (Killed).",
            137,
            "rank 1 was ended by signal 9 (SIGKILL); mostly for want of",
        ),
        (
            "----\nMPI_ABORT was invoked\nno more slots\n----",
            3,
            "mpirun ended with 3: no more slots",
        ),
        ("", 3, "mpirun ended with 3: nothing said"),
    ],
)
def test_ranks_that_end_without_an_answer(
    said: str, code: int, failure: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By an mpirun that ends as one does whose rank was killed, or that cannot start."""
    script = tmp_path / "mpirun"
    script.write_text(f"#!/bin/sh\ncat >&2 <<END\n{said}\nEND\nexit {code}\n")
    script.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    answer = compute(requested(Request.of("bending", short(), ranks=2)))
    assert (answer.status, answer.failure_class) == ("broken", MACHINE)
    assert answer.failure is not None
    assert answer.failure.startswith(failure)


# -- workers that do not close -------------------------------------------------------------------


def objective(config: Data, quantities: tuple[str, ...], ranks: int) -> Outcome:
    if config["morph"]["xi1"] > 0.5:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    return Outcome({"cog_offset_mm": 2.8, "force_N": 4.0 + config["morph"]["xi1"]})


@pytest.fixture
def stubborn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers on a thread, whose closing fails as that of Dask's nanny does."""
    from distributed import Client, LocalCluster

    @contextmanager
    def connected(where: Where) -> Iterator[Client]:
        with (
            LocalCluster(
                n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
            ) as cluster,
            Client(cluster) as client,
        ):
            yield client
        raise TimeoutError("Nanny failed to close")

    monkeypatch.setattr(pools, "connected", connected)


@pytest.mark.usefixtures("stubborn")
def test_workers_that_do_not_close_lose_nothing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    points = tuple({"morph.xi1": value / 10} for value in range(4))
    plan = Plan(Config(), ("morph.xi1",), points, objective=f"{__name__}:objective")
    standing = campaign.run(plan, tmp_path, Where())
    assert (standing.done, standing.failed) == (4, 0)
    designs = campaign.read(tmp_path).designs
    assert [(row.outputs or {})["force_N"] for row in designs] == [4, 4.1, 4.2, 4.3]
    assert "workers did not close: TimeoutError: Nanny failed to close" in caplog.text


@pytest.mark.usefixtures("stubborn")
def test_the_command_ends_with_code_1(tmp_path: Path) -> None:
    """A design that the machine does not let end; the others are kept."""
    out = tmp_path / "doe"
    call = ["doe", "--out", str(out), "--objective", f"{__name__}:objective"]
    done = CliRunner().invoke(app, [*call, "--parameter", "morph.xi1=0:1:3"])
    assert done.exit_code == 1
    assert "1 of 3 could not be computed on this machine: OSError" in done.output
    assert [row.status for row in campaign.read(out).designs] == ["done", "done", "pending"]
