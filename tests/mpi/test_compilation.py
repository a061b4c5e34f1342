"""One form that several ranks want: one of them compiles it, and all have its errors."""

from __future__ import annotations

from pathlib import Path

import pytest
from mpi4py import MPI
from support import compiling

from dolfingrip.mechanics.model.compilation import CompilationError

COMM = MPI.COMM_WORLD


def _use(patch: pytest.MonkeyPatch, folder: Path, before: tuple[str, ...] = ()) -> None:
    """Give this rank a compiler and a cache."""
    for name, value in compiling.environment(folder, before).items():
        patch.setenv(name, value)
    COMM.Barrier()


def test_ranks_of_one_cache(shared: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if COMM.rank == 0:
        compiling.environment(shared)
    COMM.Barrier()
    monkeypatch.setenv("CC", str(shared / "compiler"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(shared / "cache"))
    assert compiling.is_one(compiling.volume())
    COMM.Barrier()
    assert compiling.compiles(shared) == 1
    assert len(compiling.cached(shared)) == 1


def test_ranks_with_caches_of_their_own(shared: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on several machines without a common disk."""
    own = shared / f"rank_{COMM.rank}"
    own.mkdir()
    _use(monkeypatch, own)
    assert compiling.is_one(compiling.volume())
    assert compiling.compiles(own) == 1
    assert len(compiling.cached(own)) == 1


@pytest.mark.parametrize("failing", [0, COMM.size - 1])
def test_an_error_of_one_rank_is_everybodys(
    failing: int, shared: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No rank waits for one that could not compile."""
    own = shared / f"rank_{COMM.rank}"
    own.mkdir()
    _use(monkeypatch, own, ("exit 1",) if COMM.rank == failing else ())
    with pytest.raises(CompilationError, match="a form could not be compiled"):
        compiling.volume()
