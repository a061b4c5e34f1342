"""The Slurm cluster: the content of its job scripts, and what is refused."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from dask_jobqueue.slurm import SLURMJob

from dolfingrip.config import ConfigError
from dolfingrip.jobs import slurm

FILE = """
queue = "cpu"
account = "gripper"
walltime = "08:00:00"
memory = "24GB"
designs_per_job = 3
job_extra_directives = ["--constraint=avx2"]
job_script_prologue = ["module load openmpi"]
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("DOLFINGRIP_CHECKOUT", raising=False)
    path = tmp_path / "slurm.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


def script(settings: dict[str, object]) -> list[str]:
    job = SLURMJob("tcp://10.0.0.1:8786", "worker", **settings)
    return [line.strip() for line in job.job_script().splitlines() if line.strip()]


def test_job_script(file: Path) -> None:
    lines = script(slurm.settings(file, ranks=4))
    assert lines[0] == "#!/usr/bin/env bash"
    for directive in (
        "-p cpu", "-A gripper", "-n 1", "--cpus-per-task=12", "--mem=23G", "-t 08:00:00",
        "--constraint=avx2",
    ):  # fmt: skip
        assert f"#SBATCH {directive}" in lines
    assert lines.index("export OMP_NUM_THREADS=1") < lines.index("module load openmpi")
    worker = lines[-1]
    assert worker.startswith(f"{sys.executable} -m distributed.cli.dask_worker tcp://10.0.0.1:8786")
    # three processes of one thread: one design each at a time
    assert "--nworkers 3" in worker
    assert "--nthreads 1" in worker


def test_workers_start_in_the_environment(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOLFINGRIP_CHECKOUT", "/home/me/dolfingrip")
    worker = script(slurm.settings(file, ranks=1))[-1]
    assert worker.startswith("/home/me/dolfingrip/scripts/run python -m distributed")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("cores = 4", "cores: allowed: designs_per_job, with --ranks"),
        ("protocol = 'tcp'", "protocol: allowed: TLS, with keys made for each cluster"),
        ("scheduler_options.security = true", "security: allowed: TLS, with keys made for each"),
        ("scheduler_options = 1", "scheduler_options: allowed: a table"),
        ("queue = 'cpu'", 'memory: allowed: of one job, as in memory = "8GB"'),
        ("memory = '8GB'\ndesigns_per_job = 0", "designs_per_job = 0: allowed: at least 1"),
        ("memory", "not TOML"),
    ],
)
def test_refused_settings(text: str, said: str, file: Path) -> None:
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as refused:
        slurm.settings(file, 1)
    assert said in str(refused.value)


def test_no_settings(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="No such file"):
        slurm.settings(tmp_path / "no.toml", 1)
