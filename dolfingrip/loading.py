"""How libraries are loaded: PyPI's DOLFINx first of all, and none with settings of the folder.

The package's own modules are loaded as they are used (:func:`lazily`).

Some libraries read settings from the folder that a process works in, as they are loaded. What they
find there may name code: ``-dll_prepend`` in ``petscrc`` is a library that PETSc loads. The folder
may be a stranger's, so these libraries are loaded while the process works in the root folder.
Settings in the user's home are read.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from types import ModuleType
from typing import Any, Final

SETTINGS: Final = {
    "ezdxf": "ezdxf.ini",
    "matplotlib": "matplotlibrc",
    "mpi4py.MPI": "ucx.conf",
    "petsc4py.PETSc": "petscrc, .petscrc",
}
"""Modules that read settings from the working folder as they are loaded, and files that they read;
``ucx.conf`` is of UCX, by which Open MPI sends messages."""


@contextmanager
def elsewhere() -> Iterator[None]:
    """Work in the root folder for a while, where nobody but the system's owner leaves files.

    The working folder is the whole process', so what runs in this block should be short.
    """
    here = os.open(".", getattr(os, "O_PATH", os.O_RDONLY) | os.O_DIRECTORY)
    try:
        os.chdir("/")
        yield
    finally:
        os.fchdir(here)
        os.close(here)


class _Elsewhere(Loader):
    """Loads a module in the root folder, by its own loader.

    Args:
        loader: of the module.
    """

    def __init__(self, loader: Loader) -> None:
        self._own = loader

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Create the module."""
        with elsewhere():
            return self._own.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        """Execute the module, which finds its own loader."""
        module.__loader__ = self._own
        if module.__spec__ is not None:
            module.__spec__.loader = self._own
        with elsewhere():
            self._own.exec_module(module)


class _LoadedElsewhere(MetaPathFinder):
    """Finds the modules of :data:`SETTINGS`, to be loaded in the root folder."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find one of these modules, and no other one."""
        if fullname not in SETTINGS:
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is not None and spec.loader is not None:
            spec.loader = _Elsewhere(spec.loader)
        return spec


class _SolverOfWheel(MetaPathFinder):
    """Has PyPI's wheel of DOLFINx loaded by its own package, which loads MPI before all else."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> None:
        """Find nothing; the first import of a part of the wheel loads the wheel's package."""
        if fullname in {"dolfinx", "petsc4py"} and self in sys.meta_path:
            sys.meta_path.remove(self)
            if find_spec("dolfinx_solver"):
                # its OpenBLAS has the name of the system's, which CHOLMOD needs: the first one
                # is taken for both
                with suppress(OSError):
                    ctypes.CDLL("libcholmod.so")
                with elsewhere():
                    __import__("dolfinx_solver")


def prepare() -> None:
    """Have libraries loaded so from now on in this process."""
    sys.meta_path[:0] = [_SolverOfWheel(), _LoadedElsewhere()]


def lazily(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a package whose names are loaded as they are used.

    Args:
        package: its dotted name.
        homes: by public name the module below the package that has it; a module has its own name.
    """

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module = import_module(f"{package}.{homes[name]}")
        return module if name == homes[name] else getattr(module, name)

    return load, lambda: sorted(homes)
