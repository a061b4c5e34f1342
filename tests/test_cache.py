"""What lies in the cache is run, so one that another user could write to is refused."""

from __future__ import annotations

import os
import stat
import subprocess
from pathlib import Path

import pytest

from dolfingrip.config import ConfigError
from dolfingrip.mechanics.model import jit
from dolfingrip.sections.private import cache_folder

SCRIPTS = Path(__file__).resolve().parents[1] / "scripts"
SOMEBODY = 4321
"""Number of a user that no test is run by."""

KINDS = [
    "open",
    "below_open",
    "linked",
    pytest.param("foreign", marks=pytest.mark.skipif(os.geteuid() != 0, reason="root gives away")),
    pytest.param("below_foreign", marks=pytest.mark.skipif(os.geteuid() != 0, reason="root alone")),
]


def planted(kind: str, tmp_path: Path) -> tuple[Path, str]:
    """A cache that others can write to, and what is said of it."""
    outer, cache = tmp_path / "outer", tmp_path / "outer" / "cache"
    cache.mkdir(parents=True)
    if kind == "open":
        cache.chmod(0o775)
        return cache, f"others may write to {cache}"
    if kind == "below_open":
        outer.chmod(0o757)
        return cache / "new", f"others may write to {outer}"
    if kind == "linked":
        cache.chmod(0o1777)  # the sticky bit keeps others from renaming, not from adding
        link = tmp_path / "link"
        link.symlink_to(cache)
        return link, f"others may write to {cache}"
    theirs = cache if kind == "foreign" else outer
    os.chown(theirs, SOMEBODY, SOMEBODY)
    return cache, f"{theirs} belongs to another user"


def run(*command: str, **changes: str | None) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, **changes}
    kept = {name: value for name, value in environment.items() if value is not None}
    return subprocess.run(command, env=kept, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("command", ["run", "enter"])
def test_a_cache_that_others_can_fill(command: str, kind: str, tmp_path: Path) -> None:
    cache, said = planted(kind, tmp_path)
    done = run(str(SCRIPTS / command), "echo", "was run", DOLFINGRIP_CACHE=str(cache))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"dolfingrip: cache {cache.resolve()}: {said}; allowed: ")
    assert done.stderr.count("\n") == 1
    assert not (cache / "new").exists()


@pytest.mark.parametrize("kind", KINDS)
def test_compiled_forms_that_others_can_plant(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache, said = planted(kind, tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(ConfigError) as refused:
        cache_folder(*cache.relative_to(tmp_path).parts)
    assert str(refused.value).startswith(f"cache {cache.resolve()}: {said}; allowed: ")
    assert not (cache / "new").exists()


def test_a_cache_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also below a folder such as /tmp; whatever the umask, nobody else may write to it."""
    tmp_path.chmod(0o1777)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    before = os.umask(0o002)
    try:
        made = [Path(jit.options()["cache_dir"])]
        done = run(str(SCRIPTS / "enter"), "printenv", "XDG_CACHE_HOME", DOLFINGRIP_CHECKOUT=None,
                   DOLFINGRIP_CACHE=str(tmp_path / "shell"))  # fmt: skip
    finally:
        os.umask(before)
    assert done.returncode == 0, done.stderr
    made.append(Path(done.stdout.strip()))
    assert jit.options()["cache_dir"] == str(made[0])
    for each in made:
        while each != tmp_path:
            assert stat.S_IMODE(each.stat().st_mode) == 0o700, each
            each = each.parent
    made[0].chmod(0o777)
    with pytest.raises(ConfigError, match=f"others may write to {made[0]}; allowed"):
        jit.options()


def test_without_a_home(tmp_path: Path) -> None:
    """The home is the one that the system knows: never /tmp, and Open MPI has one, too."""
    where = run(str(SCRIPTS / "run"), "--where", HOME=None, DOLFINGRIP_CACHE=None,
                XDG_CACHE_HOME=None, DOLFINGRIP_ENV="bwrap")  # fmt: skip
    assert "/tmp" not in where.stdout + where.stderr
    call = "from mpi4py import MPI; print(MPI.COMM_WORLD.size)"
    done = run(str(SCRIPTS / "enter"), "python3", "-c", call, HOME=None, DOLFINGRIP_CHECKOUT=None,
               DOLFINGRIP_CACHE=str(tmp_path / "cache"))  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (0, "1\n", "")
