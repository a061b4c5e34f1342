"""A surrogate of the stand-in, trained once; workers that are threads."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from design import stand_in

from dolfingrip.design.surrogate.training import Training, train
from dolfingrip.jobs import pool
from dolfingrip.jobs.cluster import Where, connected


@pytest.fixture(scope="session")
def training() -> Training:
    return train(stand_in.table())


@pytest.fixture(scope="session")
def surrogate_folder(training: Training, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("surrogate")
    training.surrogate.save(folder)
    return folder


@pytest.fixture
def threads() -> Iterator[None]:
    """Jobs run on a thread of this process, for tests in which no worker dies.

    A process takes two seconds of processor to start, most of it for imports.
    """
    from distributed import LocalCluster

    with (
        LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
        ) as cluster,
        pytest.MonkeyPatch.context() as patch,  # its own: a test may undo all of its patches
    ):
        here = Where(scheduler=cluster.scheduler_address)
        patch.setattr(pool, "connected", lambda where: connected(here))
        yield
