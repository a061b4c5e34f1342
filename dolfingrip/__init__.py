"""dolfingrip: simulation, design and diagnosis of pneumatic soft-gripper fingers."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from dolfingrip import loading

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

loading.prepare()
