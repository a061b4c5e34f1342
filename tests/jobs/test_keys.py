"""A cluster talks to nobody without its key: not its scheduler, nor its workers, by any page."""

from __future__ import annotations

import asyncio
import os
import stat
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from dolfingrip.config import ConfigError
from dolfingrip.jobs import connections
from dolfingrip.jobs.cluster import Where, connected

SOMEBODY = 65534
"""Number of the user nobody."""

INTRUDER = f"""
import asyncio, os, sys
from distributed import Security
from dolfingrip.jobs import connections
from jobs.test_keys import asked

made = connections.fresh_keys()
if os.geteuid() == 0:
    os.setgroups([])
    os.setgid({SOMEBODY})
    os.setuid({SOMEBODY})
for address in sys.argv[1:]:
    for security in (Security(), made):
        for protocol in ("tcp", "tls"):
            try:
                print("let in:", asyncio.run(asked(address.replace("tls", protocol), security)))
            except Exception as error:
                print("refused:", type(error).__name__)
"""
"""Asks servers who they are, without a certificate and by its own; as another user, if by root."""


async def asked(address: str, security: Any) -> str:
    """Who answers at an address."""
    from distributed.core import rpc

    arguments = security.get_connection_args("client")
    async with rpc(address, timeout=5, connection_args=arguments) as to:
        return str((await to.identity())["type"])


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    __import__("petsc4py.PETSc")  # it takes a connection that breaks for a crash of the process
    with connected(Where()) as found:
        found.run(__import__, "petsc4py.PETSc")
        yield found


def test_nobody_without_the_key(client: Any) -> None:
    ((worker, facts),) = client.scheduler_info()["workers"].items()
    addresses = [client.scheduler.address, worker, facts["nanny"]]
    assert all(address.startswith("tls://127.0.0.1:") for address in addresses)
    with_it = [asyncio.run(asked(address, client.security)) for address in addresses]
    assert with_it == ["Scheduler", "Worker", "WorkerSupervisor"]
    done = subprocess.run(
        [sys.executable, "-c", INTRUDER, *addresses],
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    said = done.stdout.splitlines()
    assert len(said) == 4 * len(addresses), done.stderr
    assert all(line.startswith("refused: ") for line in said), said
    assert client.submit(len, [1]).result() == 1


def test_no_page_tells_of_jobs(client: Any) -> None:
    def port(dask_worker: Any) -> int:
        return int(dask_worker.http_server.port)

    ports = [client.scheduler_info()["services"]["dashboard"], *client.run(port).values()]
    for each in ports:
        for page in ("", "info/main/workers.html", "metrics", "json/index.html"):
            with pytest.raises(urllib.error.HTTPError, match="404"):
                urllib.request.urlopen(f"http://127.0.0.1:{each}/{page}", timeout=10)


def test_what_workers_import_is_nobody_elses(client: Any) -> None:
    """Dask puts its scratch folder in front of the paths of imports."""

    def paths() -> list[str]:
        return [path for path in sys.path if "scratch" in path]

    found = [*client.run(paths).values(), paths()]
    assert all(found)
    for path in (Path(path) for each in found for path in each):
        private = [
            p for p in path.parents if p.is_dir() and not stat.S_IMODE(p.stat().st_mode) & 0o77
        ]
        assert private, path


SBATCH = """#!/bin/sh
cp "$1" {folder}/job.sh
setsid bash {folder}/job.sh >{folder}/log 2>&1 &
echo $! >{folder}/pid
echo "Submitted batch job 7"
"""
SCANCEL = """#!/bin/sh
kill -TERM -- -$(cat {folder}/pid)
"""


def test_workers_of_slurm_find_their_keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In files that nobody else may read, and that end with the cluster. Slurm is two scripts."""
    bin_folder, cache = tmp_path / "bin", tmp_path / "cache"
    bin_folder.mkdir()
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
        (bin_folder / name).write_text(text.format(folder=tmp_path), encoding="utf-8")
        (bin_folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{bin_folder}:{os.environ['PATH']}")
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.delenv("DOLFINGRIP_CHECKOUT", raising=False)
    file = tmp_path / "slurm.toml"
    file.write_text('memory = "1GB"\ninterface = "lo"\n', encoding="utf-8")
    with connected(Where(slurm=file)) as client:
        future = client.submit(os.getpid)
        assert future.result(timeout=60) != os.getpid()
        assert client.scheduler.address.startswith("tls://")

        def scratch(dask_worker: Any) -> str:
            return str(dask_worker.local_directory)

        (local,) = client.run(scratch).values()
        private = Path(local).parents[1]  # dask-scratch-space lies between
        assert stat.S_IMODE(private.stat().st_mode) == 0o700
        folder = cache / "dolfingrip" / "keys"
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        files = list(folder.iterdir())
        assert {stat.S_IMODE(each.stat().st_mode) for each in files} == {0o600}
        script = (tmp_path / "job.sh").read_text(encoding="utf-8")
        assert "PRIVATE KEY" not in script
        assert all(str(each) in script for each in files)
    end = time.monotonic() + 20
    while private.exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert not private.exists()


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("tcp://127.0.0.1:1", "whoever reaches it could run code as you; allowed: tls://HOST:PORT"),
        ("127.0.0.1:1", "whoever reaches it could run code as you; allowed: tls://HOST:PORT"),
        ("tls://127.0.0.1:1", "no certificate; allowed: with one in Dask's configuration"),
    ],
)
def test_a_scheduler_without_keys(address: str, said: str) -> None:
    with (
        pytest.raises(ConfigError, match=f"^--scheduler {address}: {said}"),
        connected(Where(scheduler=address)),
    ):
        pass


@pytest.mark.parametrize("text", [None, "#!/bin/sh\necho nonsense >&2\nexit 1\n"])
def test_no_key_can_be_made(
    text: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if text is not None:
        (tmp_path / "openssl").write_text(text, encoding="ascii")
        (tmp_path / "openssl").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    said = "No such file or directory" if text is None else "nonsense"
    with pytest.raises(ConfigError, match=f"^keys of the workers: openssl: {said}$"):
        connections.fresh_keys()
