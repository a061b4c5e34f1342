"""The number of workers behind `-n auto` in pyproject.toml, and what makes processes cheap, or
spares them.
"""

from __future__ import annotations

import gc
import os
from collections import Counter
from collections.abc import Generator, Iterator
from importlib.util import find_spec

import pytest
from support import quick_forms

import dolfingrip  # noqa: F401  # before DOLFINx, whose wheel needs MPI loaded first
from dolfingrip.cli.installation import how_to_install

quick_forms.set_level()  # before any import of the package's mechanics; subprocesses inherit it

# Commands and workers that tests start find modules compiled to bytecode, as a user's do.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

BETWEEN_COLLECTIONS = 20_000
"""Objects made between two searches for reference cycles. Python's own 2,000 suits small programs:
analysis of forms makes millions of objects that live until it ends."""

MOST = 4
"""Workers on machines of many cores: each takes 1 GB, and some tests start more processes."""


def pytest_configure(config: pytest.Config) -> None:
    """Prepare what workers inherit."""
    if not hasattr(config, "workerinput"):
        os.environ.setdefault("CFLAGS", quick_forms.flags())


def _brought_by_an_extra(error: ModuleNotFoundError) -> str:
    """Say what is not here, of what the package's extras bring; "" for what has to be here."""
    name = error.name or ""
    if " extra " not in how_to_install(name) or find_spec(name.partition(".")[0]):
        return ""
    return f"{name} is not here; an extra of the package brings it"


def _skipping() -> Generator[None]:
    try:
        return (yield)
    except ModuleNotFoundError as error:
        if reason := _brought_by_an_extra(error):
            pytest.skip(reason)
        raise


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup() -> Generator[None]:
    """Skip a test whose fixture needs an extra that is not installed, as torch of a pip user's."""
    return (yield from _skipping())


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None]:
    """Skip a test that needs an extra which is not installed."""
    return (yield from _skipping())


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files that take longest come first, so that no worker has one of them left at the end."""
    tests = Counter(item.path for item in items)
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: (-slow[item.path], -tests[item.path]))


def pytest_collection_finish() -> None:
    """What modules and tests hold lasts until the end: no search for cycles looks at it again."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(BETWEEN_COLLECTIONS)


def pytest_unconfigure(config: pytest.Config) -> None:
    """Python frees them at its end, or libraries complain; workers end without that."""
    if not hasattr(config, "workerinput"):
        gc.unfreeze()


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """One worker a core; none on a single core, for tests that are named, and under mpirun.

    Tests without workers print as they go, and take breakpoints. Under mpirun each rank is one
    pytest, and all must run the same tests in the same order.
    """
    by_name = all("::" in argument for argument in config.args)
    cores = len(os.sched_getaffinity(0))
    if by_name or cores == 1 or "OMPI_COMM_WORLD_SIZE" in os.environ:
        return 0
    return min(cores, MOST)


@pytest.fixture
def threads() -> Iterator[None]:
    """Jobs run on a thread of this process, for tests in which no worker dies.

    A process takes two seconds of processor to start, most of it for imports.
    """
    from distributed import LocalCluster

    from dolfingrip.jobs import pool
    from dolfingrip.jobs.cluster import Where, connected

    with (
        LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
        ) as cluster,
        pytest.MonkeyPatch.context() as patch,  # its own: a test may undo all of its patches
    ):
        here = Where(scheduler=cluster.scheduler_address)
        patch.setattr(pool, "connected", lambda where: connected(here))
        yield
