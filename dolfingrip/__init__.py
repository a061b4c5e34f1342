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


def plugin(path: os.PathLike[str] | str) -> None:
    """Take a file of laws, effects, foods, or other things of one's own.

    It has to come before :mod:`dolfingrip.config` or an experiment is imported. On the command line
    ``--plugin FILE`` does the same.

    Args:
        path: of the file. What it adds follows from what it imports at its top, such as
            ``dolfingrip.sections.laws.law`` or ``dolfingrip.extensions.kinds``.

    Raises:
        PluginError: one line, where the file cannot be read or adds nothing, or comes too late.
    """
    from dolfingrip import plugins

    plugins.add(path)


# One thread for each MPI rank and each worker of a campaign, whose threads would fight for cores.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

loading.prepare()
