"""``dolfingrip config``."""

from __future__ import annotations

import sys

from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.cli.options import ConfigFile, Overrides


def config(config: ConfigFile = None, overrides: Overrides = None) -> None:
    """Print the resolved configuration, each key with its meaning."""
    resolved = configuration.load(config, dict(overrides or ()))
    if MPI.COMM_WORLD.rank == 0:
        sys.stdout.write(configuration.dumps(resolved))
