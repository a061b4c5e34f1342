"""CalculiX (https://www.calculix.de): a run of a deck, and what it printed."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dolfingrip.meshes.solid import SolidMesh


class Printed(NamedTuple):
    """A block of numbers in a ``.dat`` file.

    Attributes:
        what: first word of its heading, such as ``displacements``, ``forces`` or ``stresses``.
        time_s: of the increment.
        rows: number of node or element, and values.
    """

    what: str
    time_s: float
    rows: np.ndarray

    def on(self, mesh: SolidMesh) -> np.ndarray:
        """Return the values at all points of a mesh, (n, 3); NaN where none were printed.

        Args:
            mesh: whose nodes the rows are of, numbered from 1.
        """
        values = np.full_like(mesh.points, np.nan)
        values[self.rows[:, 0].astype(int) - 1] = self.rows[:, 1:]
        return values


def printed(path: Path) -> Iterator[Printed]:
    """Read the blocks of a ``.dat`` file in turn.

    Args:
        path: of the file.
    """
    for block in filter(str.strip, re.split(r"\n(?= [a-z])", path.read_text(encoding="utf-8"))):
        heading, *rows = filter(None, map(str.split, block.splitlines()))
        yield Printed(heading[0], float(heading[-1]), np.array(rows, dtype=float))


def solve(deck: Path) -> Path:
    """Run CalculiX on one core.

    Args:
        deck: ``….inp``, whose folder takes the results.

    Returns:
        The ``.dat`` file.

    Raises:
        RuntimeError: CalculiX gave up.
    """
    said = run(deck, "ccx").read_text(encoding="utf-8")
    if "*ERROR" in said or "Job finished" not in said:
        raise RuntimeError(f"{deck}: CalculiX gave up: {said[-500:]}")
    return deck.with_suffix(".dat")


def run(deck: Path, *command: str) -> Path:
    """Run a deck by CalculiX on one core.

    Args:
        deck: ``….inp``, whose folder takes the results.
        command: that starts CalculiX.

    Returns:
        What CalculiX said, ``….log``; its exit code says little.
    """
    said = deck.with_suffix(".log")
    with said.open("w", encoding="utf-8") as log:
        subprocess.run(
            [*command, deck.stem],
            cwd=deck.parent,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
            stdout=log,
            stderr=log,
            check=False,
        )
    return said
