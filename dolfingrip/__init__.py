"""dolfingrip: simulation, design and diagnosis of pneumatic soft-gripper fingers."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.abc import MetaPathFinder
from importlib.util import find_spec
from types import ModuleType
from typing import TYPE_CHECKING

__version__: str
"""Version of the installed package, which its last tag gives."""

if not TYPE_CHECKING:

    def __getattr__(name):
        """Read the version when it is asked for, as that takes longer than this import."""
        if name != "__version__":
            raise AttributeError(f"module 'dolfingrip' has no attribute {name!r}")
        from importlib import metadata

        return metadata.version("dolfingrip")


# One thread for each MPI rank and each worker of a campaign, whose threads would fight for cores.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")


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
                __import__("dolfinx_solver")


sys.meta_path.insert(0, _SolverOfWheel())
