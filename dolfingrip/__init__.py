"""dolfingrip: simulation, design and diagnosis of pneumatic soft-gripper fingers.

Its packages are loaded as they are used: ``import dolfingrip as dg; dg.config.load()``.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from dolfingrip import loading
from dolfingrip.version import __version__ as __version__

if TYPE_CHECKING:
    from dolfingrip import (
        channels,
        config,
        design,
        diagnosis,
        experiments,
        extensions,
        files,
        foods,
        jobs,
        mechanics,
        meshes,
        parameter,
        report,
        sections,
    )

__all__ = [
    "channels", "config", "design", "diagnosis", "experiments", "extensions", "files", "foods",
    "jobs", "mechanics", "meshes", "parameter", "plugin", "report", "sections",
]  # fmt: skip


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
__getattr__, __dir__ = loading.lazily(__name__, {name: name for name in __all__})
