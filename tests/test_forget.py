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


def forget(folder: Path, cache: Path, how: str = "--forget") -> str:
    """What the script says."""
    done = subprocess.run(
        [folder / "scripts" / "run", how],
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


def test_a_list_says_the_same_and_removes_nothing(cache: Path, tmp_path: Path) -> None:
    here, former = checkout(tmp_path / "here"), checkout(tmp_path / "former", "of before")
    environments = [made(cache, each) for each in (here, former)]
    shutil.rmtree(former)
    said = forget(here, cache, "--list")
    assert f"  {environments[1]}: no checkout uses it" in said
    assert " unused " in said
    assert "--forget would free " in said
    assert all(each.exists() for each in environments)
    (line,) = (line for line in said.splitlines() if " unused " in line)
    assert line.replace(" unused   ", " removed  ") in forget(here, cache).splitlines()
    assert [each.exists() for each in environments] == [True, False]


def test_a_link_that_is_of_no_checkout_any_more(cache: Path, tmp_path: Path) -> None:
    """It has no note of its checkout, as where it was interrupted."""
    here = checkout(tmp_path / "here")
    link = linked(cache, here)
    (link / "ready").unlink()
    assert f"  {link}: no checkout uses it" in forget(here, cache)
    assert not link.exists()


def test_forms_that_no_run_has_used_for_long(cache: Path, tmp_path: Path) -> None:
    here = checkout(tmp_path / "here")
    forms = made(cache, here) / "xdg" / "fenics" / "key"
    old, used = forms / "form_old", forms / "form_used"
    for each in (old, used):
        each.mkdir(parents=True)
    os.utime(old, (0.0, 0.0))
    said = forget(here, cache)
    assert "1 forms that no run has used for 60 days" in said
    assert [old.exists(), used.exists()] == [False, True]


def test_a_form_that_is_loaded_counts_as_used(tmp_path: Path) -> None:
    from dolfingrip.mechanics.model.compilation import compiled

    folder = tmp_path / "form"
    folder.mkdir()
    os.utime(folder, (0.0, 0.0))
    assert compiled(folder, lambda place: place, "a form") == folder
    assert folder.stat().st_mtime > 1e9
