"""``dolfingrip doctor``."""

from __future__ import annotations

import ctypes
import importlib
import os
import platform
import shlex
import shutil
import signal
import subprocess
import sys
import sysconfig
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

import typer

from dolfingrip.cli.installation import DOLFINX, extras
from dolfingrip.cli.settings import DoctorSettings
from dolfingrip.version import __version__

APART = {"", "all", "dolfinx", "docs", "test"}
"""Extras that have a line of their own, or that no command needs by itself."""


def doctor(_settings: DoctorSettings) -> None:
    """Say what this machine has of what the commands need, and what is missing."""
    threads = os.environ["OMP_NUM_THREADS"]
    lines = [
        ("dolfingrip", __version__),
        ("Python", f"{platform.python_version()}, {sys.executable}"),
        ("packages", _there(extras().pop(""))),
        ("DOLFINx", _dolfinx()),
        ("compiler", _compiler()),
        ("Python.h", _header()),
        ("OpenGL", _opengl()),
        ("factors", _factors()),
        ("contact", _contact()),
        ("caches", _cache()),
        *(("", line) for line in _environments()),
        ("threads", f"{threads} of each rank (OMP_NUM_THREADS), {os.cpu_count()} processors"),
        *((f"[{extra}]", _there(names)) for extra, names in extras().items() if extra not in APART),
    ]
    for name, said in lines:
        sys.stdout.write(f"{name:<12}{said}\n")
    if any(said.startswith("missing") for name, said in lines if not name.startswith("[")):
        raise typer.Exit(1)


def _dolfinx() -> str:
    try:
        dolfinx, petsc4py = map(importlib.import_module, ("dolfinx", "petsc4py"))
        petsc = importlib.import_module("petsc4py.PETSc")
    except ImportError as error:
        reason = "" if isinstance(error, ModuleNotFoundError) else f" ({error})"
        return f"missing{reason}. {DOLFINX}"
    numbers = ".".join(map(str, petsc.Sys.getVersion()))
    return f"{dolfinx.__version__}, PETSc {numbers}, petsc4py {petsc4py.__version__}"


def _compiler() -> str:
    command = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")[0]
    if not shutil.which(command):
        return f"missing ({command}): forms cannot be compiled; install gcc or clang"
    completed = subprocess.run([command, "--version"], capture_output=True, text=True, check=False)
    return next(iter(completed.stdout.splitlines()), command)


def _header() -> str:
    header = Path(sysconfig.get_path("include"), "Python.h")
    if header.exists():
        return str(header)
    return f"missing ({header}): forms cannot be compiled; install python3-dev or python3-devel"


def _opengl() -> str:
    """gmsh's wheel is linked with libGL and libGLU; pictures need EGL or a display."""
    try:
        importlib.import_module("gmsh")
    except (ImportError, OSError) as error:
        return f"missing for gmsh: {error}; install libglu1-mesa (Debian) or mesa-libGLU (Fedora)"
    if sys.platform != "linux" or os.environ.get("DISPLAY"):
        return "of the system"
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return "missing for pictures: no display and no libEGL; install libegl1"
    return "EGL, without a display"


def _factors() -> str:
    if not find_spec("dolfinx"):
        return "unknown without DOLFINx"
    from dolfingrip.mechanics.newton import cholmod

    if cholmod.available():
        return f"CHOLMOD, {cholmod.header()}"
    return "MUMPS; faster with CHOLMOD: install libsuitesparse-dev (Debian) or suitesparse (conda)"


TOUCH = """
import ipctk, numpy
faces = numpy.array([[0, 1, 2], [3, 4, 5]], dtype=numpy.int32)
at = numpy.asfortranarray(numpy.eye(6, 3))
ipctk.has_intersections(ipctk.CollisionMesh(at, ipctk.edges(faces), faces), at)
"""
"""The least that uses compiled code of contact."""


def _contact() -> str:
    """A wheel that was compiled for another processor crashes once it is used."""
    if not find_spec("ipctk"):
        return "missing (ipctk)"
    ended = subprocess.run([sys.executable, "-P", "-c", TOUCH], capture_output=True, check=False)
    version = _version("ipctk")
    if ended.returncode == 0:
        return f"ipctk {version}, works on this processor"
    why = (
        f"crashes on this processor ({signal.Signals(-ended.returncode).name})"
        if ended.returncode < 0
        else f"does not work: {ended.stderr.decode(errors='replace').splitlines()[-1]}"
    )
    return (
        f"missing: ipctk {version} {why}; install another version: pip install 'ipctk!={version}'"
    )


def _cache() -> str:
    if not find_spec("dolfinx"):
        return "unknown without DOLFINx"
    from dolfingrip.mechanics.model import jit

    present = Path(jit.options()["cache_dir"])
    every = [path for path in present.parent.glob("*") if path.is_dir()]
    of_others = sum(_megabytes(path) for path in every if path != present)
    return (
        f"{present}: forms of {_megabytes(present):.0f} MB; "
        f"{of_others:.0f} MB beside it are of other processors or of former versions"
    )


def _environments() -> list[str]:
    """Lines of ``scripts/run --list``; none outside its environment."""
    checkout = os.environ.get("DOLFINGRIP_CHECKOUT")
    if checkout is None:
        return []
    command = [f"{checkout}/scripts/run", "--list"]
    completed = subprocess.run(command, capture_output=True, text=True, check=False)
    return [line.removeprefix("dolfingrip: ") for line in completed.stderr.splitlines()]


def _megabytes(folder: Path) -> float:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6


def _there(names: list[str]) -> str:
    """Versions of distributions, or the line that installs those that are missing."""
    versions = {name: _version(name) for name in names}
    absent = [name for name, version in versions.items() if version is None]
    if absent:
        return f"missing: pip install {' '.join(absent)}"
    return ", ".join(f"{name} {version}" for name, version in versions.items())


def _version(name: str) -> str | None:
    """Version of a distribution; conda's packages of compiled libraries have none."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "" if find_spec(name.replace("-", "_")) else None
