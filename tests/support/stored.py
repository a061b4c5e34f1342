"""Readings that one rank found, which any number of ranks must find again.

``stored.json`` was written at commit 14eda85; the stone's part later, when the test had taken
another shape, the height of food in a gripper, when it was a new column, and all other than elastic
effects, when two joined them and what has weight came to rest relaxed. Where a change of the model
is meant to change figures, ``DOLFINGRIP_STORE=1 scripts/run pytest -n 0 tests/mpi`` writes them
anew, on one rank. Tetrahedra differ between versions of Gmsh; what was found on those of another
version than Debian's, on PyPI's stack, stands beside it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
from mpi4py import MPI

MESHER = ".".join(gmsh.__version__.split(".")[:2])
DEBIAN_S = "4.13"
FILE = Path(__file__).with_suffix(".json")
WRITES = "DOLFINGRIP_STORE" in os.environ

Values = float | Sequence[float] | np.ndarray


def compare(
    name: str,
    found: Mapping[str, Values],
    *,
    rtol: float,
    atol: float = 0.0,
    by_scale: bool = False,
) -> None:
    """Hold readings against those stored under a name.

    Args:
        name: of the case.
        found: numbers, or a number for each row, by the reading's name.
        rtol, atol: relative and absolute differences allowed.
        by_scale: ``rtol`` is a part of the reading's largest value, not of each value.
    """
    of_mesher = name if MESHER == DEBIAN_S else f"{name}, meshed by Gmsh {MESHER}"
    if WRITES:
        _write(of_mesher, found)
    every = json.loads(FILE.read_text(encoding="utf-8"))
    stored = every.get(of_mesher) or every[name]
    assert sorted(stored) == sorted(found)
    for reading, values in found.items():
        expected = np.array(stored[reading], dtype=float)  # null is not a number
        scale = float(np.nanmax(np.abs(expected), initial=0.0)) if by_scale else 0.0
        np.testing.assert_allclose(
            np.asarray(values, dtype=float),
            expected,
            rtol=0.0 if by_scale else rtol,
            atol=atol + rtol * scale,
            err_msg=f"{name}: {reading}",
        )


def _write(name: str, found: Mapping[str, Values]) -> None:
    assert MPI.COMM_WORLD.size == 1, "the reference is one rank"
    stored: dict[str, Any] = json.loads(FILE.read_text("utf-8")) if FILE.exists() else {}
    stored[name] = {
        reading: np.where(np.isnan(array), None, array).tolist()
        for reading, array in ((key, np.asarray(values, float)) for key, values in found.items())
    }
    FILE.write_text(json.dumps(stored, indent=1, sort_keys=True) + "\n", encoding="utf-8")
