"""``scripts/run --forget`` removes what no checkout uses from a cache, and nothing else."""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
RECIPE = ("scripts/provision", "scripts/requirements.lock")


def checkout(folder: Path, recipe: str = "as here") -> Path:
    """A checkout as far as the scripts look at it."""
    (folder / "scripts").mkdir(parents=True)
    for name in ("run", "cache", "enter", "forget"):
        shutil.copy(ROOT / "scripts" / name, folder / "scripts")
    (folder / "pyproject.toml").write_text(f"name = '{folder.name}'\n", encoding="utf-8")
    for name in RECIPE:
        (folder / name).write_text(recipe, encoding="utf-8")
    return folder


def key(folder: Path) -> str:
    """The key of a checkout's recipe."""
    content = b"".join((folder / name).read_bytes() for name in RECIPE)
    return hashlib.sha256(content).hexdigest()[:16]


def linked(cache: Path, folder: Path) -> Path:
    """The link that scripts/enter makes for a checkout."""
    told = f"{folder} {key(folder)} /opt/venv\n".encode()
    files = (folder / "pyproject.toml", folder / "scripts" / "enter")
    content = told + b"".join(file.read_bytes() for file in files)
    link = cache / "venv" / hashlib.sha256(content).hexdigest()[:16]
    link.mkdir(parents=True)
    (link / "ready").write_text(f"{folder}\n{key(folder)}\n/opt/venv\n", encoding="utf-8")
    return link


@pytest.fixture
def cache(tmp_path: Path) -> Path:
    """An empty cache."""
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o700)
    return folder


def made(cache: Path, folder: Path) -> Path:
    """The environment of a checkout, with its log and lock."""
    environment = cache / key(folder)
    (environment / "root").mkdir(parents=True)
    for end in (".log", ".lock"):
        environment.with_suffix(end).touch()
    return environment


def forget(folder: Path, cache: Path) -> str:
    """What the script says."""
    done = subprocess.run(
        [folder / "scripts" / "run", "--forget"],
        env={**os.environ, "DOLFINGRIP_CACHE": str(cache)}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stderr


def test_former_recipes_and_checkouts_that_are_gone(cache: Path, tmp_path: Path) -> None:
    here, other = checkout(tmp_path / "here"), checkout(tmp_path / "other", "another")
    former = checkout(tmp_path / "former", "of before")
    environments = {each: made(cache, each) for each in (here, other, former)}
    links = {each: linked(cache, each) for each in (here, other, former)}
    (former / RECIPE[0]).write_text("as here", encoding="utf-8")  # it has changed meanwhile
    (former / RECIPE[1]).write_text("as here", encoding="utf-8")
    kept = {environments[here], environments[other], links[here], links[other]}
    said = forget(here, cache)
    for each in (*environments.values(), *links.values()):
        assert each.exists() == (each in kept)
        line = next(line for line in said.splitlines() if f"  {each}: " in line)
        assert (" kept " in line) == (each in kept)
    assert str(other) in said
    assert not environments[former].with_suffix(".log").exists()
    assert environments[here].with_suffix(".log").exists()


def test_other_files_and_what_is_being_made_stay(cache: Path, tmp_path: Path) -> None:
    here = checkout(tmp_path / "here")
    (cache / "fenics").mkdir()
    part = cache / f"{'a' * 16}.part"
    part.mkdir()
    with part.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        said = forget(here, cache)
    assert "is being made" in said
    assert part.exists()
    assert (cache / "fenics").exists()
