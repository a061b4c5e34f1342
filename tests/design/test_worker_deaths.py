"""Workers that die while they start, or after they answered and before the answer is fetched."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from support import analytic

from dolfingrip.config import Config
from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.jobs.cluster import Where, connected
from dolfingrip.jobs.job import WorkerPolicy
from dolfingrip.jobs.pool import SchedulerGone
from dolfingrip.jobs.run import Standing
from dolfingrip.jobs.spool import Spool
from dolfingrip.sections.errors import ConfigError

TESTS = Path(__file__).parents[1]
DESIGNS = ("morph.xi1=-0.2:0.5:3", "morph.xi2=-0.5:1:2")
START_S = 1.5
"""About what a worker takes from its first moment to its first task."""


def workers(client: psutil.Process) -> list[psutil.Process]:
    """Processes of workers, from their very first moment."""
    found = []
    for child in client.children():
        try:
            if any("spawn_main" in word for word in child.cmdline()):
                found.append(child)
        except psutil.NoSuchProcess:
            continue
    return found


def registered(worker: psutil.Process) -> bool:
    """True once it is connected to the scheduler, which may have given it a job."""
    try:
        return bool(worker.net_connections("tcp"))
    except psutil.NoSuchProcess:
        return False


@pytest.mark.slow
@pytest.mark.parametrize("number", range(2))
def test_workers_killed_while_they_start(tmp_path: Path, number: int) -> None:
    """Up to five die before the first task, some of them in place of one that died.

    A job that more than two workers died on is given up. So no more than two die that may have one,
    though the first task is still to come: a worker has its job before it has imported what that
    needs, and a machine that is busy takes long to import it.
    """
    seed = int(os.environ.get("DOLFINGRIP_TEST_SEED", "5")) + number
    print(f"seed {seed}")
    moments = random.Random(seed)
    log, out = tmp_path / "log", tmp_path / "doe"
    call = [
        sys.executable, "-P", "-m", "dolfingrip", "doe", "--objective", analytic.PATH,
        "--out", str(out), "--workers", "2", *(f"--parameter={each}" for each in DESIGNS),
    ]  # fmt: skip
    environment = {**os.environ, "DOLFINGRIP_TEST_LOG": str(log), "PYTHONPATH": str(TESTS)}
    began = time.monotonic()
    with subprocess.Popen(
        call, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        client = psutil.Process(process.pid)
        ends: dict[int, float] = {}  # when each is killed
        killed: dict[int, bool] = {}  # and whether it was registered then
        while len(killed) < 5 and process.poll() is None and not log.exists():
            for worker in workers(client):
                if worker.pid not in ends:
                    delay_s = moments.uniform(0, START_S) if ends else 0.0  # the first at once
                    ends[worker.pid] = time.monotonic() + delay_s
                elif worker.pid not in killed and time.monotonic() > ends[worker.pid]:
                    at_work = registered(worker)
                    if at_work and sum(killed.values()) == WorkerPolicy().lost_workers:
                        continue
                    os.kill(worker.pid, signal.SIGKILL)
                    killed[worker.pid] = at_work
            time.sleep(0.005)
        try:  # the rest takes about as long as the starts so far, on this machine as it is now
            said = process.communicate(timeout=90 + 10 * (time.monotonic() - began))[0]
        finally:
            process.kill()
    print(f"{len(killed)} killed, {sum(killed.values())} of them registered")
    assert process.returncode == 0, said
    assert "6 designs: 6 computed now, 6 done, 0 failed" in said
    assert killed


@pytest.mark.parametrize("shared", [True, False])
def test_answers_lost_with_their_worker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shared: bool
) -> None:
    """Dask holds two answers for the client when the worker that computed them is killed."""
    from distributed import default_client

    if not shared:  # the client sees no spool of the worker
        monkeypatch.setattr(Spool, "read", lambda spool, key: None)
    killed = []

    def states() -> list[str]:
        return [state.status for state in list(default_client().futures.values())]

    def until(wanted: str, number: int) -> None:
        end = time.monotonic() + 30
        while states().count(wanted) < number:
            assert time.monotonic() < end, states()
            time.sleep(0.001)

    def progress(standing: Standing) -> None:
        if standing.computed == 1:
            until("finished", 2)
            killed.append(next(iter(default_client().run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)
            until("lost", 2)

    points = tuple({"morph.xi1": value} for value in (0.1, 0.2, 0.3))
    plan = Plan(Config(), ("morph.xi1",), points, objective=analytic.PATH)
    standing = campaign.run(plan, tmp_path, Where(), progress=progress)
    assert killed
    assert (standing.computed, standing.done) == (3, 3)


def test_a_scheduler_that_ends_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from distributed import LocalCluster

    monkeypatch.setenv("DOLFINGRIP_TEST_SECONDS", "0.5")
    points = tuple({"morph.xi1": value / 100} for value in range(20))
    plan = Plan(Config(), ("morph.xi1",), points, objective=analytic.PATH)
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
    ) as cluster:

        def progress(standing: Standing) -> None:
            if standing.computed == 1:
                cluster.close()

        where = Where(scheduler=cluster.scheduler_address)
        with pytest.raises(SchedulerGone, match="what was computed is kept"):
            campaign.run(plan, tmp_path, where, progress=progress)


def test_workers_that_never_start_are_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    from distributed.nanny import WorkerProcess

    monkeypatch.setattr(WorkerProcess, "_run", staticmethod(analytic.dies))
    with (
        pytest.raises(ConfigError, match=r"^--workers 1: none could be started: [^\n]*$"),
        connected(Where(), WorkerPolicy(starts=2)),
    ):
        pass


def test_a_worker_may_take_long_to_come_back() -> None:
    """Dask would give it up after 15 s, and the campaign would wait for ever."""
    import dask

    with connected(Where()):
        assert dask.config.get("distributed.deploy.lost-worker-timeout") == "1h"
