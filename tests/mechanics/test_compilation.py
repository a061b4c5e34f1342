"""Compiles that are interrupted, wanted by several at once, fail, or find what others left."""

from __future__ import annotations

import errno
import fcntl
import logging
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path
from typing import Any

import basix.ufl
import pytest
import typer
import ufl
from support import compiling
from support.command import in_this_process

from dolfingrip.cli import edge
from dolfingrip.jobs.job import MACHINE, Job
from dolfingrip.jobs.work import compute
from dolfingrip.mechanics.model.compilation import CompilationError, compiled, told_to

LIMIT_S = 120.0


@contextmanager
def compiling_elsewhere(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Another process in the midst of a compile, which goes on once there is ``folder/go``."""
    started, go = folder / "started", folder / "go"
    held_up = (f"touch '{started}'", f"until [ -e '{go}' ]; do sleep 0.05; done")
    process = subprocess.Popen(
        [sys.executable, compiling.__file__],
        env=os.environ | compiling.environment(folder, held_up),
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        latest = time.monotonic() + LIMIT_S
        while not started.exists() and process.poll() is None and time.monotonic() < latest:
            time.sleep(0.05)
        assert started.exists()
        yield process
    finally:
        go.touch()
        process.kill()
        process.communicate()


def use(patch: pytest.MonkeyPatch, environment: dict[str, str]) -> None:
    """Set variables of the environment."""
    for name, value in environment.items():
        patch.setenv(name, value)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_the_next_command_does_not_wait_for_an_interrupted_one(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SIGINT goes to the compiler, too, as Ctrl-C does; of SIGKILL it hears nothing."""
    said: list[str] = []
    with compiling_elsewhere(tmp_path) as process:
        assert len(compiling.cached(tmp_path)) == 2  # the lock, and what has been begun
        (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
        assert process.wait(LIMIT_S) != 0
        assert bool(compiling.cached(tmp_path)) == (number == signal.SIGKILL)
        use(monkeypatch, compiling.environment(tmp_path))
        with told_to(said.append):  # while the killed one's compiler still runs
            assert compiling.is_one(compiling.volume())
    assert not any("waiting" in line for line in said)
    assert compiling.compiles(tmp_path) == 2
    (form,) = compiling.cached(tmp_path)
    assert list(form.glob("*.so"))


def test_two_processes_want_one_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second tells after two seconds that it waits for the first, which tells what it does."""
    said: list[str] = []

    def hear(line: str) -> None:
        said.append(line)
        (tmp_path / "go").touch()

    with compiling_elsewhere(tmp_path) as process:
        use(monkeypatch, compiling.environment(tmp_path))
        with told_to(hear):
            assert compiling.is_one(compiling.volume())
        _, first_said = process.communicate(timeout=LIMIT_S)
    assert process.returncode == 0
    assert compiling.compiles(tmp_path) == 1
    assert len(compiling.cached(tmp_path)) == 1
    assert said[0].startswith("waiting for another process on ")
    assert said[0].endswith(", which compiles a form, 2 s")
    assert said[-1] == ""
    assert first_said.splitlines().count("dolfingrip: compiling a form, 2 s") == 1


def test_threads_want_one_folder(tmp_path: Path) -> None:
    """One of them fills it, the others load what it holds."""
    filled: list[str] = []

    def get(folder: Path) -> str:
        file = folder / "code"
        if not file.exists():
            filled.append(folder.name)
            time.sleep(0.1)
            file.write_text("code", encoding="ascii")
        return file.read_text(encoding="ascii")

    with ThreadPoolExecutor(8) as threads:
        wanted = [tmp_path / name for name in 4 * ("one", "two")]
        found = list(threads.map(lambda folder: compiled(folder, get, "code"), wanted))
    assert found == 8 * ["code"]
    assert sorted(name.partition(".")[0] for name in filled) == ["one", "two"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "two"]


@pytest.mark.parametrize("left", ["lock", "part", "source", "library"])
def test_what_another_machine_left_does_not_count(
    left: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A lock that nobody holds, a folder half made, a source without a library, half a library."""
    use(monkeypatch, compiling.environment(tmp_path, cache="other"))
    compiling.volume()
    (whole,) = compiling.cached(tmp_path, "other")
    form = tmp_path / "cache" / whole.relative_to(tmp_path / "other")
    source, library = next(whole.glob("*.c")), next(whole.glob("*.so"))
    part = form.with_name(f"{form.name}.0a1b2c3d.part")
    for folder in (part, form) if left in ("source", "library") else (part,):
        folder.mkdir(parents=True)
        (folder / source.name).write_bytes(source.read_bytes()[:99])
    if left == "lock":
        form.with_name(f"{form.name}.lock").write_bytes(b" on another machine\n\xff")
    if left == "library":
        (form / f"{source.name}.cached").touch()
        (form / library.name).write_bytes(library.read_bytes()[:99])
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert compiling.is_one(compiling.volume())
    assert compiling.compiles(tmp_path) == 2
    assert compiling.cached(tmp_path) == [form]
    assert (form / library.name).stat().st_size == library.stat().st_size


def test_a_failed_compile_is_the_machines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Nothing is left of it; the job's answer and the command's line say whose fault it was."""
    handlers = list(logging.root.handlers)
    use(monkeypatch, compiling.environment(tmp_path, ["exit 1"]))
    with pytest.raises(
        CompilationError,
        match=r"a form could not be compiled: .*(failed with|returned non-zero) exit",
    ):
        compiling.volume()
    assert compiling.cached(tmp_path) == []
    assert logging.root.handlers == handlers
    job = Job("volume", "support.compiling:volume", {})
    answer = compute(job)
    assert (answer.status, answer.failure_class) == ("broken", MACHINE)
    capfd.readouterr()

    command = typer.Typer()
    command.command()(lambda: print(compiling.volume()))
    monkeypatch.setattr(sys, "argv", ["dolfingrip"])
    with in_this_process(), pytest.raises(SystemExit) as ended:
        edge.run(lambda: typer.main.get_command(command))
    assert ended.value.code == 1
    said = capfd.readouterr().err.splitlines()
    assert [line for line in said if line.startswith("dolfingrip: a form could not be compiled")]
    assert not any("Traceback" in line for line in said)

    use(monkeypatch, compiling.environment(tmp_path))
    assert compute(job).status == "done"


@pytest.mark.parametrize("locks", [True, False])
def test_what_another_process_has_begun_stays_on_a_disk_without_locks(
    locks: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who holds the lock knows that a part of a form is of nobody who lives."""

    def refused(*arguments: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    if not locks:
        monkeypatch.setattr(fcntl, "flock", refused)
    folder, begun = tmp_path / "form", tmp_path / "form.0123abcd.part"
    begun.mkdir()

    def get(place: Path) -> str:
        (place / "code").touch()
        return "loaded"

    assert compiled(folder, get, "a form") == "loaded"
    assert (folder / "code").exists()
    assert begun.exists() is not locks


def test_a_process_lists_entry_points_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of all packages, which setuptools wants six times for each form."""
    looks: list[str] = []
    distributions = metadata.distributions

    def noted(**where: Any) -> Any:
        looks.append("looked")
        return distributions(**where)

    monkeypatch.setattr(metadata, "distributions", noted)
    for cache in ("first", "second"):
        use(monkeypatch, compiling.environment(tmp_path, cache=cache))
        before = len(looks)
        assert compiling.is_one(compiling.volume())
    assert compiling.compiles(tmp_path) == 2
    assert len(looks) == before
    metadata.entry_points()  # others ask as ever
    assert len(looks) == before + 1


def test_equal_expressions_are_compared_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there are 2¹⁶ ways down to the one field."""
    domain = ufl.Mesh(basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,)))
    space = ufl.FunctionSpace(domain, basix.ufl.element("Lagrange", "tetrahedron", 1))
    compared: list[object] = []

    def noted(one: ufl.Coefficient, other: object) -> bool:
        compared.append(other)
        return isinstance(other, ufl.Coefficient) and one.count() == other.count()

    monkeypatch.setattr(ufl.Coefficient, "__eq__", noted)

    def built(number: int) -> Any:
        made = ufl.Coefficient(space, number)
        for _ in range(16):
            made = ufl.sin(made) + ufl.cos(made)
        return made

    assert built(0) == built(0)
    assert len(compared) < 100  # UFL puts the terms of each sum in order
    assert built(0) != built(1)
