"""A tiny form in a cache of its own, and a compiler that tests hold up."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import dolfingrip  # noqa: F401  # before DOLFINx, whose wheel needs MPI loaded first

# isort: split
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfingrip.mechanics.model import jit

COMPILER = """#!/bin/sh
echo "$@" >> '{log}'
{before}
exec gcc "$@"
"""


def environment(folder: Path, before: Sequence[str] = (), cache: str = "cache") -> dict[str, str]:
    """Variables for a compiler that notes its calls, and for a cache.

    Args:
        folder: for both.
        before: lines of shell before each call of gcc.
        cache: name of the cache.
    """
    program = folder / "compiler"
    lines = "\n".join(before)
    program.write_text(COMPILER.format(log=folder / "calls", before=lines), encoding="utf-8")
    program.chmod(0o755)
    return {"CC": str(program), "XDG_CACHE_HOME": str(folder / cache)}


def compiles(folder: Path) -> int:
    """How often the compiler was called for a source."""
    calls = folder / "calls"
    lines = calls.read_text(encoding="utf-8").splitlines() if calls.exists() else []
    return sum(" -c " in line for line in lines)


def cached(folder: Path, cache: str = "cache") -> list[Path]:
    """What is in the cache."""
    return [path for place in (folder / cache / "fenics").glob("*") for path in place.iterdir()]


def volume() -> dict[str, float]:
    """Volume of a unit cube, by a form."""
    cube = mesh.create_unit_cube(MPI.COMM_WORLD, 2, 2, 2)
    form = fem.form(fem.Constant(cube, 1.0) * ufl.dx, jit_options=jit.options())
    return {"mm3": cube.comm.allreduce(fem.assemble_scalar(form))}


def is_one(found: dict[str, float]) -> bool:
    """Whether it is the cube's volume; sums of its cells' volumes differ by rounding."""
    return abs(found["mm3"] - 1.0) < 1e-12


if __name__ == "__main__":
    assert is_one(volume()), os.getpid()
